#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "pipeline/batch/manifest_rows.h"
#include "pipeline/data/error.h"

namespace hexrelief::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kName = "{name}", kLeft = "left", kRight = "right";
constexpr std::array<std::string_view, 9> kImageEndings = {".png", ".jpg", ".jpeg", ".ppm", ".pgm",
                                                           ".pnm", ".tif", ".tiff", ".webp"};

// A pattern split into the folder, the path component that contains {name}, and what follows that component.
struct Pattern {
    fs::path folder;         // above the component with {name}
    std::string head, tail;  // parts of that component before and after {name}
    std::string below;       // "/left.png" if the files are in a folder of that name; else empty
    bool any_image = false;  // ".*" was at its end and has been removed
};

Pattern parse_pattern(std::string text) {
    Pattern pattern;
    if (text.ends_with(".*")) {
        pattern.any_image = true;
        text.erase(text.size() - 2);
    }
    const std::size_t at = text.find(kName), after = at + kName.size();
    if (at == std::string::npos || text.find(kName, after) != std::string::npos ||
        text.find(kLeft, after) == std::string::npos)
        throw Error(ErrorKind::usage, "pattern '" + text +
                                          "': must hold {name} once and 'left' after it, as "
                                          "'{name}_left.png' and '{name}/left.png' do");
    const std::size_t slash = text.rfind('/', at), next = std::min(text.find('/', after), text.size());
    const std::size_t begin = slash == std::string::npos ? 0 : slash + 1;
    pattern.folder = begin == 0 ? "." : text.substr(0, begin);
    pattern.head = text.substr(begin, at - begin);
    pattern.tail = text.substr(after, next - after);
    pattern.below = text.substr(next);
    return pattern;
}

// Returns `text` with `to` in place of the last "left".
std::string replace_left(std::string text, std::string_view to) {
    return text.replace(text.rfind(kLeft), kLeft.size(), to);
}

// Returns the file itself or, for a pattern of any image, the one that exists; empty if there is none.
fs::path existing_image(const fs::path& path, bool any_image) {
    std::error_code none;
    if (!any_image) return fs::is_regular_file(path, none) ? path : fs::path();
    for (const std::string_view ending : kImageEndings)
        if (const fs::path image = path.string() + std::string(ending); fs::is_regular_file(image, none))
            return image;
    return {};
}

// Returns the text that stands for {name} in a component's name; empty if it does not match.
std::string matched_name(std::string component, const Pattern& pattern) {
    if (pattern.any_image && pattern.below.empty()) {
        const std::string ending = fs::path(component).extension();
        if (std::find(kImageEndings.begin(), kImageEndings.end(), ending) == kImageEndings.end()) return {};
        component.erase(component.size() - ending.size());
    }
    if (component.size() <= pattern.head.size() + pattern.tail.size()) return {};
    if (!component.starts_with(pattern.head) || !component.ends_with(pattern.tail)) return {};
    return component.substr(pattern.head.size(),
                            component.size() - pattern.head.size() - pattern.tail.size());
}

}  // namespace

std::vector<ManifestRow> pattern_rows(const fs::path& text) {
    const Pattern pattern = parse_pattern(text.string());
    std::map<std::string, ManifestRow> rows;
    std::error_code code;
    for (auto it = fs::directory_iterator(pattern.folder, code); it != fs::directory_iterator();
         it.increment(code)) {
        const std::string name = matched_name(it->path().filename().string(), pattern);
        if (name.empty()) continue;
        const std::string stem =
            (pattern.folder / (pattern.head + name + pattern.tail + pattern.below)).lexically_normal();
        const fs::path left = existing_image(stem, pattern.any_image),
                       right = existing_image(replace_left(stem, kRight), pattern.any_image);
        if (left.empty()) continue;
        ManifestRow row{left.string(), {{"name", name}, {"left", left.string()}}, {}};
        if (right.empty())
            row.wrong =
                "its right image is missing: " + replace_left(stem, kRight) + (pattern.any_image ? ".*" : "");
        row.values.emplace_back("right", right.string());
        const fs::path calibration =
            replace_left(pattern.any_image ? stem : fs::path(stem).replace_extension().string(), "calib") +
            ".txt";
        if (fs::is_regular_file(calibration, code)) row.values.emplace_back("calib", calibration.string());
        rows.emplace(name, std::move(row));
    }
    if (code) throw Error(ErrorKind::input, "cannot list " + pattern.folder.string() + ": " + code.message());
    std::vector<ManifestRow> sorted;
    for (auto& [name, row] : rows) sorted.push_back(std::move(row));
    if (sorted.empty()) throw Error(ErrorKind::input, "no pair is named as '" + text.string() + "'");
    return sorted;
}

}  // namespace hexrelief::batch
