// Chooses the cameras in files that have those of several picture sizes, sockets or views.
#include <algorithm>
#include <map>

#include "pipeline/readers/cameras/key_table.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

struct Choice {
    std::string name;  // as it stands in keys
    int width = 0, height = 0;
};

// Returns the choice of the pictures' size, else the largest of their aspect, else refuses with all sizes.
// The first one if the pictures' size is not known.
const Choice& choose(const CalibrationText& source, const std::vector<Choice>& choices) {
    if (source.width == 0) return choices.front();
    const Choice* chosen = nullptr;
    std::string sizes;
    for (const Choice& choice : choices) {
        if (choice.width == source.width && choice.height == source.height) return choice;
        const bool fits = 1LL * choice.width * source.height == 1LL * choice.height * source.width;
        if (fits && (!chosen || choice.width > chosen->width)) chosen = &choice;
        sizes +=
            (sizes.empty() ? "" : ", ") + std::to_string(choice.width) + "x" + std::to_string(choice.height);
    }
    if (!chosen)
        refuse_key(source, "the file",
                   "has cameras of " + sizes + " px, but the picture has " + std::to_string(source.width) +
                       "x" + std::to_string(source.height) + " px; give the picture as it was taken");
    return *chosen;
}

void add(Entries& entries, const std::string& name, const std::string& value) {
    entries.push_back({name, {value}});
}

}  // namespace

// The sections LEFT_CAM_HD and RIGHT_CAM_HD, and the keys CV_HD, RX_HD, RZ_HD of the section STEREO.
Entries select_zed(const CalibrationText& source, Entries entries) {
    static const std::vector<Choice> all = {
        {"vga", 672, 376},       {"svga", 960, 600}, {"hd", 1280, 720},       {"fhd", 1920, 1080},
        {"fhd1200", 1920, 1200}, {"2k", 2208, 1242}, {"qhdplus", 3200, 1800}, {"4k", 3840, 2160}};
    std::vector<Choice> there;
    for (const Choice& choice : all)
        if (std::any_of(entries.begin(), entries.end(),
                        [&](const Entry& entry) { return entry.key == "leftcam" + choice.name + ".fx"; }))
            there.push_back(choice);
    if (there.empty()) refuse_key(source, "LEFT_CAM_HD", "is missing");
    const Choice& chosen = choose(source, there);
    const std::map<std::string, std::string> lengths = {
        {"stereo.baseline", "translation.x"}, {"stereo.ty", "translation.y"}, {"stereo.tz", "translation.z"}};
    Entries selected;
    for (Entry& entry : entries) {
        std::string key = entry.key;
        for (const auto& [section, side] :
             {std::pair{"leftcam" + chosen.name + ".", "left."}, {"rightcam" + chosen.name + ".", "right."}})
            if (key.starts_with(section))
                selected.push_back({side + key.substr(section.size()), entry.values});
        if (const auto length = lengths.find(key); length != lengths.end())
            selected.push_back({length->second, entry.values});
        else if (key.starts_with("stereo.") && key.ends_with(chosen.name) &&
                 (key.size() == 9 + chosen.name.size()))
            selected.push_back({key.substr(0, 9), entry.values});
    }
    add(selected, "width", std::to_string(chosen.width));
    add(selected, "height", std::to_string(chosen.height));
    return selected;
}

// The keys rectified.N.fx, fy, ppx, ppy, width and height, and the baseline in mm, of either sign.
Entries select_d400(const CalibrationText& source, Entries entries) {
    std::map<std::string, double> numbers;
    for (const Entry& entry : entries)
        if (entry.values.size() == 1 && (entry.key == "baseline" || entry.key.starts_with("rectified.")))
            numbers[entry.key] = require_number(source, entry.name, entry.values[0]);
    std::vector<Choice> there;
    for (int i = 0; i < 32; ++i) {
        const std::string name = "rectified." + std::to_string(i) + ".";
        const double width = numbers[name + "width"], height = numbers[name + "height"];
        // Sizes that a device does not have are listed with focal lengths of 0.
        if (width >= 1 && width < 1e5 && height >= 1 && height < 1e5 && numbers[name + "fx"] > 1)
            there.push_back({name, static_cast<int>(width), static_cast<int>(height)});
    }
    if (there.empty()) refuse_key(source, "rectified.0", "needs fx, fy, ppx, ppy, width and height");
    const Choice& chosen = choose(source, there);
    Entries selected;
    for (Entry& entry : entries) {
        if (entry.key.starts_with(chosen.name))
            selected.push_back({entry.key.substr(chosen.name.size()), entry.values});
        if (entry.key == "baseline" && numbers["baseline"] > 0) entry.values[0] = "-" + entry.values[0];
        if (entry.key == "baseline") selected.push_back({"baseline", entry.values});
    }
    return selected;
}

// The cameras cameraData.N.1 of the sockets cameraData.N.0; the movement is that of the camera whose
// extrinsics lead to the other one.
Entries select_oak(const CalibrationText& source, Entries entries) {
    std::map<std::string, std::string> single;
    for (const Entry& entry : entries)
        if (entry.values.size() == 1) single[entry.key] = entry.values[0];
    const auto socket = [&](const char* key, const char* otherwise) {
        const auto found = single.find(std::string("stereorectificationdata.") + key);
        return found != single.end() ? found->second : std::string(otherwise);
    };
    const std::string left = socket("leftcamerasocket", "1"), right = socket("rightcamerasocket", "2");
    const auto place_of = [&](const std::string& wanted) {
        for (const auto& [key, value] : single) {
            const bool is_socket = key.starts_with("cameradata.") && key.ends_with(".0") && value == wanted;
            if (is_socket) return key.substr(0, key.size() - 1) + "1.";
        }
        refuse_key(source, "cameraData", "has no camera of the socket " + excerpt(wanted));
    };
    const std::string left_place = place_of(left), right_place = place_of(right);
    if (single[left_place + "extrinsics.tocamerasocket"] != right)
        refuse_key(source, "cameraData",
                   "has no extrinsics from the left camera to the right one (toCameraSocket)");
    Entries selected;
    for (Entry& entry : entries) {
        const bool is_left = entry.key.starts_with(left_place), is_right = entry.key.starts_with(right_place);
        if (!is_left && !is_right) continue;
        const std::string name = entry.key.substr((is_left ? left_place : right_place).size());
        const bool is_movement =
            name == "extrinsics.rotationmatrix" || name.starts_with("extrinsics.translation");
        if (is_movement && is_left) selected.push_back({name, entry.values});
        if (name.starts_with("extrinsics")) continue;
        // A fisheye lens uses the first four numbers.
        const bool is_fisheye = single[(is_left ? left_place : right_place) + "cameratype"] == "1";
        if (is_fisheye && name == "distortioncoeff" && entry.values.size() > 4) entry.values.resize(4);
        selected.push_back({(is_left ? "left." : "right.") + name, entry.values});
        if (name == "distortioncoeff") add(selected, "model", is_fisheye ? "fisheye" : "pinhole");
    }
    return selected;
}

// The keys NUMBER.cam_K, and frames.N.fl_x with frames.N.file_path, which go before those of all frames.
Entries select_view(const CalibrationText& source, Entries entries) {
    std::string own;
    for (const std::filesystem::path& view : source.views) {
        const std::string stem = view.stem().string();
        std::string number = stem.substr(0, stem.find_first_not_of("0123456789"));
        if (!number.empty()) number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
        for (const Entry& entry : entries) {
            if (entry.key.ends_with(".filepath") && !entry.values.empty() &&
                std::filesystem::path(entry.values[0]).stem() == stem)
                own = entry.key.substr(0, entry.key.rfind('.') + 1);
            if (!number.empty() && entry.key.starts_with(number + ".")) own = number + ".";
        }
        if (!own.empty()) break;
    }
    if (own.empty()) return entries;
    Entries selected;
    for (const Entry& entry : entries)
        if (entry.key.starts_with(own))
            selected.push_back({entry.name.substr(own.size()), entry.values});
        else if (entry.key.find('.') == std::string::npos &&
                 std::ranges::none_of(entries, [&](const Entry& one) { return one.key == own + entry.key; }))
            selected.push_back({entry.name, entry.values});
    return selected;
}

}  // namespace hexrelief::readers::codec
