// Parses COLMAP's cameras.txt: CAMERA_ID MODEL WIDTH HEIGHT PARAMS[] in each line, and cameras.bin as such
// lines.
#include <algorithm>
#include <bit>
#include <iterator>
#include <span>

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

// The models by their numbers in cameras.bin, and how many parameters each has.
struct Model {
    std::string_view name;
    std::size_t parameters;
};
constexpr Model kModels[] = {{"SIMPLE_PINHOLE", 3},
                             {"PINHOLE", 4},
                             {"SIMPLE_RADIAL", 4},
                             {"RADIAL", 5},
                             {"OPENCV", 8},
                             {"OPENCV_FISHEYE", 8},
                             {"FULL_OPENCV", 12},
                             {"FOV", 5},
                             {"SIMPLE_RADIAL_FISHEYE", 4},
                             {"RADIAL_FISHEYE", 5},
                             {"THIN_PRISM_FISHEYE", 12}};

// Takes little-endian numbers from the front; `is_short` once they are used up.
struct ByteReader {
    std::span<const std::uint8_t> bytes;
    bool is_short = false;

    std::uint64_t take(std::size_t count) {
        is_short |= bytes.size() < count;
        if (is_short) return 0;
        std::uint64_t value = 0;
        for (std::size_t i = count; i-- > 0;) value = value << 8 | bytes[i];
        bytes = bytes.subspan(count);
        return value;
    }
};

}  // namespace

// The file is its number of cameras, and of each id, model, width, height and the parameters.
std::optional<std::string> text_of_colmap(const std::vector<std::uint8_t>& bytes) {
    ByteReader reader{bytes};
    const std::uint64_t cameras = reader.take(8);
    if (reader.is_short || cameras == 0 || cameras > bytes.size() / 48) return std::nullopt;
    std::string text;
    for (std::uint64_t i = 0; i < cameras; ++i) {
        const std::uint64_t id = reader.take(4), model = reader.take(4), width = reader.take(8),
                            height = reader.take(8);
        if (reader.is_short || model >= std::size(kModels)) return std::nullopt;
        text += std::to_string(id) + " " + std::string(kModels[model].name) + " " + std::to_string(width) +
                " " + std::to_string(height);
        for (std::size_t k = 0; k < kModels[model].parameters; ++k)
            text += " " + exact_text(std::bit_cast<double>(reader.take(8)));
        text += "\n";
    }
    if (reader.is_short || !reader.bytes.empty()) return std::nullopt;
    return text;
}

std::optional<Calibration> parse_colmap(CalibrationText& source) {
    const std::vector<Words> entries = entries_of(source.text);
    if (entries.empty() || entries[0].size() < 2 || !parse_number(entries[0][0]) || !is_model(entries[0][1]))
        return std::nullopt;
    source.format = "COLMAP";
    const Words& entry = entries[0];
    const bool are_same = std::ranges::all_of(entries, [&](const Words& other) {
        return std::equal(entry.begin() + 1, entry.end(), other.begin() + 1, other.end());
    });
    if (!are_same)
        refuse_key(source, "the file",
                   "has " + std::to_string(entries.size()) + " cameras; keep the line of the picture's own");
    const std::string model(entry[1]), key = "camera " + std::string(entry[0]);
    const bool simple = model == "SIMPLE_PINHOLE" || model == "SIMPLE_RADIAL" || model == "RADIAL";
    const bool is_straight = model == "PINHOLE" || model == "OPENCV" || model == "FULL_OPENCV" || simple;
    const std::size_t pinhole = simple ? 7 : 8;  // entries of the camera without its lens
    const auto bends = [&](std::string_view text) { return require_number(source, key, text) != 0; };
    if (!is_straight ||
        (!model.ends_with("PINHOLE") && entry.size() > pinhole &&
         std::any_of(entry.begin() + static_cast<std::ptrdiff_t>(pinhole), entry.end(), bends)))
        refuse_key(source, key,
                   "is of the model " + excerpt(model) +
                       ", with distortion; undistort the pictures first (colmap image_undistorter) and take "
                       "the PINHOLE camera that this writes");
    const std::size_t expected = 4 + std::ranges::find(kModels, model, &Model::name)->parameters;
    if (entry.size() != expected)
        refuse_key(source, key,
                   "has " + std::to_string(entry.size()) + " entries; " + model + " has " +
                       std::to_string(expected) +
                       (simple ? ": id, model, width, height, f, cx, cy"
                               : ": id, model, width, height, fx, fy, cx, cy") +
                       (expected > pinhole ? " and the lens" : ""));
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
