// Parses numbers alone: a matrix K of 3x3, 3x4 or 4x4, by numpy.savetxt or by hand, which a baseline follows
// in FoundationStereo's file; fx fy cx cy, as of DROID-SLAM, and w h fx fy cx cy, as of ARKitScenes. Also the
// matrices of MVSNet, under the words extrinsic and intrinsic.
#include <algorithm>

#include "pipeline/readers/cameras/calibration_formats.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

// Returns the words of the text without comments and brackets.
std::vector<std::string> numbers_of(std::string_view text) {
    std::string plain;
    for (const std::string_view line : lines(text))
        plain += std::string(line.substr(0, line.find('#'))) + " ";
    for (char& c : plain)
        if (c == '[' || c == ']' || c == ';' || c == '(' || c == ')') c = ' ';
    std::vector<std::string> found;
    for (const std::string_view word : words(plain)) found.emplace_back(word);
    return found;
}

}  // namespace

std::optional<Calibration> parse_matrix(CalibrationText& source) {
    const std::vector<std::string> parts = numbers_of(source.text);
    if (parts.empty() || !parse_number(parts.front())) return std::nullopt;
    std::vector<double> values;
    for (std::size_t i = 0; i < parts.size(); ++i)
        values.push_back(require_number(source, "number " + std::to_string(i + 1), parts[i]));
    const std::size_t count = values.size();
    source.format = "camera matrix";
    if (count == 4 || count == 6) {
        source.format = "numbers alone";
        const std::size_t at = count - 4;
        Pinhole camera{.fx = values[at], .fy = values[at + 1], .cx = values[at + 2], .cy = values[at + 3]};
        if (count == 6) {
            camera.width = require_side(source, "the width", values[0]);
            camera.height = require_side(source, "the height", values[1]);
        }
        return from_pinhole(source, "fx and fy", camera);
    }
    if (count != 9 && count != 10 && count != 12 && count != 16)
        refuse_key(
            source, "the file",
            "has " + std::to_string(count) +
                " numbers; a 3x3 camera matrix has 9, and a baseline in metres may follow, 3x4 has 12, 4x4 "
                "16, fx fy cx cy 4, w h fx fy cx cy 6");
    const double baseline_m = values.back();
    if (count == 10) values.resize(9);
    Calibration calibration =
        from_pinhole(source, "the matrix", from_matrix(source, "the matrix", upper_left(values)));
    if (count == 10) {
        source.format = "camera matrix and baseline";
        source.has_baseline = true;
        calibration.baseline_m = baseline_m;
    }
    return calibration;
}

std::optional<Calibration> parse_mvsnet(CalibrationText& source) {
    const std::vector<std::string> parts = numbers_of(source.text);
    const auto found = std::find(parts.begin(), parts.end(), "intrinsic");
    if (parts.empty() || parts.front() != "extrinsic" || found == parts.end()) return std::nullopt;
    source.format = "MVSNet";
    if (parts.end() - found < 10) refuse_key(source, "intrinsic", "must be followed by the 9 numbers of K");
    std::vector<double> k;
    for (auto part = found + 1; part != found + 10; ++part)
        k.push_back(require_number(source, "intrinsic", *part));
    return from_pinhole(source, "intrinsic", from_matrix(source, "intrinsic", k));
}

}  // namespace hexrelief::readers::codec
