#include "pipeline/batch/file_pattern.h"

#include <algorithm>
#include <optional>

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::batch {
namespace {

namespace fs = std::filesystem;

// Returns the endings of the formats that hold pictures, EXR's left out, which are rarely pictures.
const std::vector<std::string>& image_endings() {
    static const std::vector<std::string> endings = [] {
        std::vector<std::string> found;
        for (const readers::codec::Codec& codec : readers::codec::codecs()) {
            if ((codec.gives & readers::codec::kPicture) == 0 || codec.format == readers::codec::Format::exr)
                continue;
            const auto own = readers::codec::words(codec.endings);
            found.insert(found.end(), own.begin(), own.end());
        }
        return found;
    }();
    return endings;
}

bool equal_but_for_case(std::string_view a, std::string_view b) {
    return readers::codec::lower_case(std::string(a)) == readers::codec::lower_case(std::string(b));
}

bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) >= 0x80;
}

// Returns the rank of a file's ending among those of images; their number if it is no image.
std::size_t image_rank(const fs::path& file) {
    const std::string ending = file.extension().string();
    const std::vector<std::string>& known = image_endings();
    return static_cast<std::size_t>(
        std::ranges::find_if(known, [&](const std::string& one) { return equal_but_for_case(one, ending); }) -
        known.begin());
}

struct Part {
    std::string head, tail;  // before and after {name}; without it, all is in `head`
    bool has_name = false, any_image = false;

    explicit Part(std::string text) {
        any_image = text.ends_with(".*");
        if (any_image) text.erase(text.size() - 2);
        const std::size_t at = text.find(kName);
        has_name = at != std::string::npos;
        head = text.substr(0, at);
        if (has_name) tail = text.substr(at + kName.size());
    }

    // Returns the text that stands for {name}, "" if there is none to stand for; nullopt if the name does not
    // match.
    std::optional<std::string> match(std::string name, NextToLetters next) const {
        if (any_image) {
            if (image_rank(name) == image_endings().size()) return std::nullopt;
            name = fs::path(name).stem().string();
        }
        if (!has_name) return equal_but_for_case(name, head) ? std::optional<std::string>("") : std::nullopt;
        if (name.size() <= head.size() + tail.size()) return std::nullopt;
        const std::string_view whole = name;
        const std::string_view text = whole.substr(head.size(), name.size() - head.size() - tail.size());
        if (!equal_but_for_case(whole.substr(0, head.size()), head) ||
            !equal_but_for_case(whole.substr(name.size() - tail.size()), tail))
            return std::nullopt;
        if (next == NextToLetters::any) return std::string(text);
        if (!head.empty() && is_letter(head.back()) && is_letter(text.front())) return std::nullopt;
        if (!tail.empty() && is_letter(tail.front()) && is_letter(text.back())) return std::nullopt;
        return std::string(text);
    }
};

struct Search {
    std::vector<std::string> parts;
    NextToLetters next;
    Listings& listings;
    std::map<std::string, fs::path> found = {};

    void look(const fs::path& folder, std::size_t index, const std::string& name) {
        if (index == parts.size()) return take(folder, name);
        const Part part(parts[index]);
        if (!part.has_name && !part.any_image) return look(folder / parts[index], index + 1, name);
        for (const std::string& entry : listings.of(folder.empty() ? "." : folder))
            if (const auto text = part.match(entry, next))
                look(folder / entry, index + 1, part.has_name ? *text : name);
    }

    void take(const fs::path& file, const std::string& name) {
        std::error_code none;
        if (!fs::is_regular_file(file, none)) return;
        const auto [known, is_new] = found.try_emplace(name, file);
        if (!is_new && image_rank(file) < image_rank(known->second)) known->second = file;
    }
};

}  // namespace

const std::vector<std::string>& Listings::of(const fs::path& folder) {
    const auto [known, is_new] = names_.try_emplace(folder);
    std::error_code code;
    if (!is_new || !fs::is_directory(folder, code)) return known->second;
    for (auto it = fs::directory_iterator(folder, code); it != fs::directory_iterator(); it.increment(code))
        if (std::string name = it->path().filename().string(); !name.starts_with('.'))
            known->second.push_back(std::move(name));
    if (code) throw Error(ErrorKind::input, "cannot list " + folder.string() + ": " + code.message());
    std::ranges::sort(known->second);
    return known->second;
}

std::map<std::string, fs::path> files_like(const fs::path& folder, const std::string& pattern,
                                           NextToLetters next, Listings& listings) {
    Search search{{}, next, listings};
    for (const fs::path& part : fs::path(pattern)) search.parts.push_back(part.string());
    search.look(folder, 0, "");
    return std::move(search.found);
}

std::string filled(std::string pattern, std::string_view name) {
    const std::size_t at = pattern.find(kName);
    return at == std::string::npos ? pattern : pattern.replace(at, kName.size(), name);
}

std::string PairRule::files() const {
    return left + (*right ? std::string(" and ") + right : "");
}

std::span<const PairRule> pair_rules() {
    static const std::vector<PairRule> rules = {
        {"side by side", "{name}sbs.*", "", {"{name}calib.*"}, true, "sbs"},
        {"side by side, in words", "{name}side-by-side.*", "", {"{name}calib.*"}, true, "sbs"},
        {"left and right in one", "{name}left-right.*", "", {"{name}calib.*"}, true, "sbs"},
        {"left over right", "{name}over-under.*", "", {"{name}calib.*"}, true, "tb"},
        {"left and right", "left.*", "right.*", {"calib.*"}},
        {"Middlebury 2003", "im2.*", "im6.*", {"calib.*"}, false},
        {"Middlebury 2006", "view1.*", "view5.*", {"calib.*"}, false},
        {"Middlebury 2014", "im0.*", "im1.*", {"calib.*"}},
        {"KITTI",
         "image_2/{name}.*",
         "image_3/{name}.*",
         {"calib/{name}.*", "calib/{frame}.*", "calib_cam_to_cam/{frame}.*", "calib.*"}},
        {"KITTI 2012", "colored_0/{name}.*", "colored_1/{name}.*", {"calib/{frame}.*"}},
        {"KITTI, grey", "image_0/{name}.*", "image_1/{name}.*", {"calib/{frame}.*", "calib.*"}},
        {"KITTI raw",
         "image_02/data/{name}.*",
         "image_03/data/{name}.*",
         {"calib_cam_to_cam.*", "../calib_cam_to_cam.*"}},
        {"EuRoC", "cam0/data/{name}.*", "cam1/data/{name}.*", {"cam0/sensor.*"}},
        {"folders cam0 and cam1", "cam0/{name}.*", "cam1/{name}.*", {"calib.*"}},
        {"left- and right- in folders", "left/left{name}.*", "right/right{name}.*", {"calib.*"}},
        {"-left and -right in folders", "left/{name}left.*", "right/{name}right.*", {"calib.*"}},
        {"folders left and right", "left/{name}.*", "right/{name}.*", {"calib/{name}.*", "calib.*"}},
        {"-left and -right", "{name}left.*", "{name}right.*", {"{name}calib.*", "calib.*"}},
        {"left- and right-", "left{name}.*", "right{name}.*", {"calib{name}.*", "calib.*"}, false},
        {"-L and -R", "{name}L.*", "{name}R.*", {"{name}calib.*", "calib.*"}, false},
        {"L- and R-", "L{name}.*", "R{name}.*", {"calib.*"}, false},
        {"JPS", "{name}.jps", "", {"{name}_calib.*", "calib.*"}},
        {"PNS", "{name}.pns", "", {"{name}_calib.*", "calib.*"}},
        {"MPO", "{name}.mpo", "", {"{name}_calib.*", "calib.*"}},
        {"spatial photograph", "{name}.heic", "", {"{name}_calib.*"}, true, "", "ster"},
    };
    return rules;
}

std::span<const SideWords> side_words() {
    static constexpr SideWords words[] = {{"left", "right"},      {"im0", "im1"},
                                          {"im2", "im6"},         {"view1", "view5"},
                                          {"image_2", "image_3"}, {"colored_0", "colored_1"},
                                          {"image_0", "image_1"}, {"image_02", "image_03"},
                                          {"cam0", "cam1"},       {"_L", "_R"}};
    return words;
}

}  // namespace hexrelief::batch
