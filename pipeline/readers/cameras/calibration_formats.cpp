#include "pipeline/readers/cameras/calibration_formats.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <span>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {
namespace {

std::string matrix_text(const SourceFile& source) {
    std::string text;
    for (const double number : read_npy_numbers(source)) text += exact_text(number) + " ";
    return text;
}

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
           std::ranges::all_of(word, [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; });
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

CalibrationText load_calibration_text(const std::filesystem::path& path) {
    constexpr std::uintmax_t longest = 1u << 20;  // lists of thousands of poses are longer than a calibration
    const SourceFile source = load_file(path, longest);
    std::string text(source.bytes.begin(), source.bytes.end());
    if (text.starts_with("\x93NUMPY")) text = matrix_text(source);
    if (auto colmap = text_of_colmap(source.bytes)) text = std::move(*colmap);
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
    if (text.find('\0') != std::string::npos && !text.starts_with("PK\3\4"))
        refuse(path, "it is a binary file, not a calibration; give calib.txt, KITTI or OpenCV YAML");
    CalibrationText loaded;
    loaded.path = path;
    loaded.text = std::move(text);
    return loaded;
}

void refuse_key(const CalibrationText& source, std::string_view key, const std::string& reason) {
    refuse(source.path, std::string(key) + " " + reason);
}

double require_number(const CalibrationText& source, std::string_view key, std::string_view text) {
    if (const auto value = parse_number(text)) return *value;
    refuse_key(source, key, "is " + excerpt(trim(text)) + "; it must be a finite number");
}

int require_side(const CalibrationText& source, std::string_view key, double value) {
    if (value >= 1 && value <= 1e9 && value == std::floor(value)) return static_cast<int>(value);
    refuse_key(source, key, "must be a whole number of pixels, at least 1");
}

double require_square(CalibrationText& source, std::string_view key, double fx, double fy) {
    if (fx == fy) return fx;
    const std::string lengths = "focal lengths " + number_text(fx) + " and " + number_text(fy);
    if (!(std::abs(fx - fy) <= 0.01 * std::abs(fx)))
        refuse_key(source, key, "has " + lengths + "; pixels must be square, scale the images first");
    source.told.push_back(std::string(key) + " has " + lengths + "; their mean is used");
    return 0.5 * (fx + fy);
}

void require_one_focal(const CalibrationText& source, std::string_view key, double left, double right) {
    if (std::abs(left - right) <= 0.005 * std::abs(left)) return;
    refuse_key(source, key,
               "have focal lengths " + number_text(left) + " and " + number_text(right) +
                   "; rectified images have one");
}

Calibration from_projections(const Projection& left, const Projection& right) {
    return {.focal_px = left[0],
            .cx = left[2] + kPixelCentre,
            .cy = left[6] + kPixelCentre,
            .baseline_m = left[3] / left[0] - right[3] / right[0],
            .doffs_px = right[2] - left[2]};
}

std::vector<double> upper_left(const std::vector<double>& m) {
    if (m.size() == 9) return m;
    return {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
}

Pinhole from_matrix(const CalibrationText& source, std::string_view key, const std::vector<double>& matrix) {
    if (matrix.size() != 9)
        refuse_key(source, key, "has " + std::to_string(matrix.size()) + " numbers; a 3x3 matrix has 9");
    const bool by_columns = matrix[2] == 0 && matrix[5] == 0;
    const auto at = [&](int row, int column) {
        return matrix[static_cast<std::size_t>(by_columns ? column * 3 + row : row * 3 + column)];
    };
    if (at(2, 0) != 0 || at(2, 1) != 0 || at(2, 2) != 1 || at(1, 0) != 0)
        refuse_key(source, key, "is no camera matrix; fx 0 cx, 0 fy cy, 0 0 1 is expected");
    if (std::abs(at(0, 1)) > 0.001 * std::abs(at(0, 0)))
        refuse_key(source, key, "has the skew " + number_text(at(0, 1)) + "; it must be 0");
    return {.fx = at(0, 0), .fy = at(1, 1), .cx = at(0, 2), .cy = at(1, 2)};
}

Calibration from_pinhole(CalibrationText& source, std::string_view key, const Pinhole& camera,
                         double pixel_centre) {
    source.has_baseline = false;
    return {.focal_px = require_square(source, key, camera.fx, camera.fy),
            .cx = camera.cx + pixel_centre,
            .cy = camera.cy + pixel_centre,
            .width = camera.width,
            .height = camera.height};
}

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
