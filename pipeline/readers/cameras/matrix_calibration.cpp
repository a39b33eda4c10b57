// Parses a matrix K of nine numbers, by numpy.savetxt or by hand; in FoundationStereo's
// file the baseline follows.
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
    if (values.size() != 9 && values.size() != 10)
        refuse_key(source, "the file",
                   "has " + std::to_string(values.size()) +
                       " numbers; a 3x3 camera matrix has 9, and a baseline in metres may follow");
    const bool with_baseline = values.size() == 10;
    const double baseline_m = values.back();
    values.resize(9);
    Calibration calibration = from_pinhole(source, "the matrix", from_matrix(source, "the matrix", values));
    source.format = with_baseline ? "camera matrix and baseline" : "camera matrix";
    source.has_baseline = with_baseline;
    if (with_baseline) calibration.baseline_m = baseline_m;
    return calibration;
}

}  // namespace hexrelief::readers::codec
