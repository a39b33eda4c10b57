// Parses KITTI's calibration files: "P2: " and the twelve numbers of a 3x4 projection matrix in each line.
#include <functional>
#include <map>

#include "pipeline/readers/cameras/calibration_formats.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

using Entries = std::map<std::string, std::string, std::less<>>;

// Returns the camera's digit in a key "P2" or "P_rect_02"; -1 for any other key.
int camera_of(std::string_view key) {
    for (std::string_view prefix : {"P_rect_0", "P"}) {
        if (key.starts_with(prefix) && key.size() == prefix.size() + 1 && key.back() >= '0' &&
            key.back() <= '3') {
            return key.back() - '0';
        }
    }
    return -1;
}

// Returns only the entries of the cameras' matrices and sizes; a file also has rotations,
// times and lidar poses.
Entries read_entries(const CalibrationText& source) {
    Entries entries;
    for (std::string_view line : lines(source.text)) {
        const std::size_t colon = line.find(':');
        if (colon == std::string_view::npos) continue;
        const std::string_view key = trim(line.substr(0, colon)), value = trim(line.substr(colon + 1));
        if (camera_of(key) < 0 && !key.starts_with("S_rect_0")) continue;
        if (value.starts_with('!') || value.starts_with('[') || value.empty())
            return {};  // this is YAML with keys of that name
        if (!entries.emplace(key, value).second) refuse_key(source, key, "is given twice; keep one");
    }
    return entries;
}

Projection read_projection(CalibrationText& source, const std::string& key, std::string_view text) {
    const auto parts = words(text);
    if (parts.size() != 12) {
        refuse_key(source, key, "has " + std::to_string(parts.size()) + " numbers; a 3x4 matrix has 12");
    }
    Projection p{};
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = require_number(source, key, parts[i]);
    if (!(p[0] > 0)) refuse_key(source, key, "has a focal length that is not above 0");
    p[0] = require_square(source, key, p[0], p[5]);
    return p;
}

Calibration from_pair(CalibrationText& source, const Entries& entries, const std::string& left,
                      const std::string& right) {
    const Projection l = read_projection(source, left, entries.find(left)->second);
    const Projection r = read_projection(source, right, entries.find(right)->second);
    require_one_focal(source, left + " and " + right, l[0], r[0]);
    return from_projections(l, r);
}

}  // namespace

std::optional<Calibration> parse_kitti(CalibrationText& source) {
    const Entries entries = read_entries(source);
    bool any = false;
    for (const auto& [key, value] : entries) any = any || camera_of(key) >= 0;
    if (!any) return std::nullopt;
    source.format = "KITTI";

    for (const auto& [left, right] : {std::pair{2, 3}, {0, 1}}) {
        for (const std::string prefix : {"P_rect_0", "P"}) {
            const std::string l = prefix + std::to_string(left), r = prefix + std::to_string(right);
            if (!entries.contains(l) || !entries.contains(r)) continue;
            Calibration calibration = from_pair(source, entries, l, r);
            const std::string size = "S_rect_0" + std::to_string(left);
            if (const auto found = entries.find(size); found != entries.end()) {
                const auto parts = words(found->second);
                if (parts.size() != 2) refuse_key(source, size, "must hold width and height");
                calibration.width = require_side(source, size, require_number(source, size, parts[0]));
                calibration.height = require_side(source, size, require_number(source, size, parts[1]));
            }
            return calibration;
        }
    }
    refuse_key(source, "P2 and P3 (or P0 and P1)",
               "are not both there; a KITTI calibration needs a left and a right one");
}

}  // namespace hexrelief::readers::codec
