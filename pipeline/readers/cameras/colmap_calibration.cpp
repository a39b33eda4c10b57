// Parses COLMAP's cameras.txt: CAMERA_ID MODEL WIDTH HEIGHT PARAMS[] in each line.
#include <algorithm>

#include "pipeline/readers/cameras/calibration_formats.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

using Words = std::vector<std::string_view>;

std::vector<Words> entries_of(std::string_view text) {
    std::vector<Words> entries;
    for (const std::string_view line : lines(text))
        if (const Words parts = words(line.substr(0, line.find('#'))); !parts.empty())
            entries.push_back(parts);
    return entries;
}

// True for the name of a model: SIMPLE_RADIAL, OPENCV, THIN_PRISM_FISHEYE, ...
bool is_model(std::string_view word) {
    return word.size() > 2 &&
           std::all_of(word.begin(), word.end(), [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; });
}

}  // namespace

std::optional<Calibration> parse_colmap(CalibrationText& source) {
    const std::vector<Words> entries = entries_of(source.text);
    if (entries.empty() || entries[0].size() < 2 || !parse_number(entries[0][0]) || !is_model(entries[0][1]))
        return std::nullopt;
    source.format = "COLMAP cameras.txt";
    if (entries.size() > 1)
        refuse_key(source, "the file",
                   "has " + std::to_string(entries.size()) + " cameras; keep the line of the picture's own");
    const Words& entry = entries[0];
    const std::string model(entry[1]), key = "camera " + std::string(entry[0]);
    const bool simple = model == "SIMPLE_PINHOLE";
    if (!simple && model != "PINHOLE")
        refuse_key(source, key,
                   "is of the model " + excerpt(model) +
                       ", with distortion; undistort the pictures first (colmap image_undistorter) and take "
                       "the PINHOLE camera that this writes");
    const std::size_t expected = simple ? 7 : 8;
    if (entry.size() != expected)
        refuse_key(source, key,
                   "has " + std::to_string(entry.size()) + " entries; " + model + " has " +
                       std::to_string(expected) +
                       (simple ? ": id, model, width, height, f, cx, cy"
                               : ": id, model, width, height, fx, fy, cx, cy"));
    const auto number = [&](std::size_t i) { return require_number(source, key, entry[i]); };
    const std::size_t fy = simple ? 4 : 5;
    // COLMAP counts the centre of pixel 0 as 0.5, as Calibration does.
    return from_pinhole(source, key,
                        {.fx = number(4),
                         .fy = number(fy),
                         .cx = number(fy + 1),
                         .cy = number(fy + 2),
                         .width = require_side(source, key + "'s width", number(2)),
                         .height = require_side(source, key + "'s height", number(3))},
                        0);
}

}  // namespace hexrelief::readers::codec
