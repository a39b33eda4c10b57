// The cameras of a pair as it was taken, and the choice of cameras in files that have those of several
// picture sizes, sockets or views.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/cameras/camera_parts.h"
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
    for (const Choice& choice : choices) {
        if (choice.width == source.width && choice.height == source.height) return choice;
        const bool fits = 1LL * choice.width * source.height == 1LL * choice.height * source.width;
        if (fits && (!chosen || choice.width > chosen->width)) chosen = &choice;
    }
    if (!chosen)
        refuse_key(source, "the file",
                   "has cameras of " +
                       joined(choices, ", ",
                              [](const Choice& choice) { return size_text(choice.width, choice.height); }) +
                       " px, but the picture has " + size_text(source.width, source.height) +
                       " px; give the picture as it was taken");
    return *chosen;
}

void add(Entries& entries, const std::string& name, const std::string& value) {
    entries.push_back({name, {value}});
}

void check_rotation(const CalibrationText& source, const std::array<double, 9>& r) {
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            double product = 0;
            for (std::size_t k = 0; k < 3; ++k) product += r[3 * i + k] * r[3 * j + k];
            if (!(std::abs(product - (i == j ? 1 : 0)) < 0.001))
                refuse_key(source, "R", "is no rotation matrix");
        }
    const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                               r[2] * (r[3] * r[7] - r[4] * r[6]);
    if (determinant < 0) refuse_key(source, "R", "is no rotation matrix: it mirrors");
}

// The names of lens models, in plain_name().
constexpr std::array kFisheyes = {
    "fisheye", "equidistant", "kannalabrandt", "kannalabrandt4", "kannalabrandt8", "kb4", "kb8"};
constexpr std::array kPinholes = {
    "pinhole",      "radtan",      "radialtangential", "plumbbob", "rationalpolynomial",
    "brownconrady", "perspective", "rectified",        "none",     "opencv"};

}  // namespace

// The sections LEFT_CAM_HD and RIGHT_CAM_HD, and the keys CV_HD, RX_HD, RZ_HD of the section STEREO.
Entries select_zed(const CalibrationText& source, Entries entries) {
    static const std::vector<Choice> all = {
        {"vga", 672, 376},       {"svga", 960, 600}, {"hd", 1280, 720},       {"fhd", 1920, 1080},
        {"fhd1200", 1920, 1200}, {"2k", 2208, 1242}, {"qhdplus", 3200, 1800}, {"4k", 3840, 2160}};
    std::vector<Choice> there;
    for (const Choice& choice : all)
        if (std::ranges::any_of(
                entries, [&](const Entry& entry) { return entry.key == "leftcam" + choice.name + ".fx"; }))
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

StereoCalibration::Camera CameraParts::camera(Side side) {
    const bool is_left = side != Side::right;
    if (!has_camera(side))
        refuse_key(source_, is_left ? "K1" : "K2", "is missing; rectifying a pair needs K1 and K2");
    const Pinhole pinhole = lengths(side, true);
    const std::string name = has(Part::matrix, side) ? find(Part::matrix, side)->name : "a camera";
    if (!(pinhole.fx > 0) || !(pinhole.fy > 0))
        refuse_key(source_, name, "has a focal length that is not above 0");
    if (!std::isfinite(pinhole.cx) || !std::isfinite(pinhole.cy))
        refuse_key(source_, name, "has no principal point");
    StereoCalibration::Camera read;
    read.matrix = {pinhole.fx, 0, pinhole.cx - family_.centre, 0, pinhole.fy, pinhole.cy - family_.centre, 0,
                   0,          1};
    read.distortion = distortion(side);
    if (read.distortion.empty())
        refuse_key(source_, is_left ? "D1" : "D2",
                   "is missing; rectifying a pair needs D1 and D2 (zeros where the lenses do not distort)");
    constexpr std::size_t counts[] = {4, 5, 8, 12, 14};
    if (std::find(std::begin(counts), std::end(counts), read.distortion.size()) == std::end(counts))
        refuse_key(
            source_, find(Part::distortion, side)->name,
            "has " + std::to_string(read.distortion.size()) + " numbers; OpenCV has 4, 5, 8, 12 or 14");
    return read;
}

bool CameraParts::is_fisheye(const StereoCalibration& pair) {
    const bool four = pair.left.distortion.size() == 4 && pair.right.distortion.size() == 4;
    bool is_said = false, says_fisheye = false;
    for (const Entry& entry : entries_) {
        const std::optional<Meaning> meaning = meaning_of(entry);
        if (!meaning || meaning->part != Part::model) continue;
        const std::string model = plain_name(entry.values[0]);
        const bool fisheye = std::ranges::find(kFisheyes, model) != kFisheyes.end();
        if (!fisheye && std::ranges::find(kPinholes, model) == kPinholes.end())
            refuse_key(
                source_, entry.name,
                "is " + excerpt(entry.values[0]) + "; pinhole and fisheye (equidistant) lenses are read");
        is_said = true;
        says_fisheye |= fisheye;
    }
    if (says_fisheye && !four)
        refuse_key(source_, "D1 or D2", "is not of 4 numbers, as the fisheye model has them");
    if (is_said || !four) return says_fisheye;
    source_.told.emplace_back(
        "4 numbers of distortion are taken for cv::fisheye's; where they are k1, k2, p1, p2, add the line "
        "model: pinhole");
    return true;
}

bool CameraParts::has_rotation() const {
    return has(Part::rotation) || has(Part::transposed) || has(Part::rotation_x) || has(Part::rotation_y) ||
           has(Part::rotation_z);
}

bool CameraParts::has_movement() const {
    const auto both = [&](Part part) { return has(part, Side::left) && has(part, Side::right); };
    const bool moves = has(Part::translation) || has(Part::translation_x);
    return (has_rotation() && moves) || has(Part::transform, Side::right) || has(Part::transform) ||
           has(Part::transform_back) || both(Part::pose) || both(Part::body_to_camera) ||
           (both(Part::rectification) && both(Part::projection));
}

Rigid CameraParts::movement() const {
    const auto matrix = [&](Part part, Side side) { return rigid_of(numbers(part, side, 16)); };
    if (has(Part::transform, Side::right)) return matrix(Part::transform, Side::right);
    if (has(Part::transform)) return matrix(Part::transform, Side::none);
    if (has(Part::transform_back)) return inverse(matrix(Part::transform_back, Side::none));
    if (has(Part::pose, Side::right) && has(Part::pose, Side::left))
        return product(inverse(matrix(Part::pose, Side::right)), matrix(Part::pose, Side::left));
    if (has(Part::body_to_camera, Side::right) && has(Part::body_to_camera, Side::left))
        return product(matrix(Part::body_to_camera, Side::right),
                       inverse(matrix(Part::body_to_camera, Side::left)));
    if (!has_rotation() && has(Part::rectification, Side::left) && has(Part::rectification, Side::right) &&
        has(Part::projection, Side::right)) {
        Rigid left, right;
        std::ranges::copy(numbers(Part::rectification, Side::left), left.rotation.begin());
        std::ranges::copy(numbers(Part::rectification, Side::right), right.rotation.begin());
        const std::vector<double> p = numbers(Part::projection, Side::right);
        if (p[0] == 0)
            refuse_key(source_, find(Part::projection, Side::right)->name, "has the focal length 0");
        left.translation = {p[3] / p[0], p[5] != 0 ? p[7] / p[5] : 0, 0};
        return product(inverse(right), left);
    }
    for (const auto& [name, is_there] :
         {std::pair{"R", has_rotation()}, {"T", has(Part::translation) || has(Part::translation_x)}})
        if (!is_there)
            refuse_key(
                source_, name,
                "is missing; rectifying a pair needs R and T between the cameras, which OpenCV's sample "
                "writes into extrinsics.yml: give both files, each by --calib");
    Rigid moved;
    if (has(Part::translation)) {
        std::ranges::copy(numbers(Part::translation), moved.translation.begin());
    } else {
        for (const Part part : {Part::translation_y, Part::translation_z})
            if (!has(part)) refuse_key(source_, "the translation", "must have x, y and z");
        moved.translation = {number(Part::translation_x), number(Part::translation_y),
                             number(Part::translation_z)};
    }
    for (double& length : moved.translation) length *= family_.unit_m;
    if (has(Part::transposed)) {
        std::ranges::copy(numbers(Part::transposed), moved.rotation.begin());
        moved.rotation = transposed(moved.rotation);
    } else if (has(Part::rotation)) {
        const std::vector<double> r = numbers(Part::rotation);
        if (r.size() == 3)
            moved.rotation = rotation_about(r[0], r[1], r[2]);
        else
            std::ranges::copy(numbers(Part::rotation, Side::none, 9), moved.rotation.begin());
    } else {
        const auto turn = [&](Part part) { return has(part) ? number(part) : 0; };
        moved.rotation =
            rotation_about(turn(Part::rotation_x), turn(Part::rotation_y), turn(Part::rotation_z));
    }
    return moved;
}

StereoCalibration CameraParts::pair() {
    StereoCalibration pair{.left = camera(left_side()), .right = camera(Side::right)};
    const Rigid moved = movement();
    pair.rotation = moved.rotation;
    pair.translation = moved.translation;
    check_rotation(source_, pair.rotation);
    pair.is_fisheye = is_fisheye(pair);
    std::tie(pair.width, pair.height) = size(left_side());
    return pair;
}

}  // namespace hexrelief::readers::codec
