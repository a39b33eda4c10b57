// Reads "name = value" lines: ZED's files with their [sections], and what MATLAB writes, whose matrices
// [1 2; 3 4] may go on over several lines, or shows, with the rows below the name.
#include <algorithm>
#include <cctype>

#include "pipeline/readers/cameras/entries.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

bool is_name(std::string_view text) {
    return !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
           std::all_of(text.begin(), text.end(), [](char c) {
               return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
           });
}

std::string_view without_comment(std::string_view line) {
    return trim(line.substr(0, std::min(line.find('%'), line.find('#'))));
}

// Returns the words of a value without brackets, quotes and semicolons.
std::vector<std::string> words_of(std::string value) {
    for (char& c : value)
        if (std::string_view("[](){};'\"").find(c) != std::string_view::npos) c = ' ';
    std::vector<std::string> found;
    for (const std::string_view word : words(value))
        if (word != "...") found.emplace_back(word);
    return found;
}

// Appends a row of numbers, or takes a line such as "1.0e+03 *" as the factor of those that follow. False if
// the line is neither.
bool append_shown(std::string_view line, double& factor, std::vector<std::string>& values) {
    std::vector<std::string_view> row = words(line);
    const bool is_factor = row.size() == 2 && row[1] == "*";
    if (is_factor) row.pop_back();
    std::vector<double> numbers;
    for (const std::string_view word : row) {
        const auto number = parse_number(word);
        if (!number) return false;
        numbers.push_back(*number);
    }
    if (is_factor)
        factor = numbers[0];
    else
        for (const double number : numbers) values.push_back(exact_text(factor * number));
    return true;
}

}  // namespace

Entries assigned_entries(const CalibrationText& source) {
    Entries entries;
    std::string section;
    bool is_open = false;   // within the brackets of the last entry
    bool is_shown = false;  // rows of the last entry follow, as MATLAB shows a matrix
    double factor = 1;      // of these rows
    std::string value;
    const auto end_value = [&] {
        is_open = value.find('[') != std::string::npos && value.find(']') == std::string::npos;
        if (!is_open) entries.back().values = words_of(value);
    };
    for (const std::string_view whole : lines(source.text)) {
        const std::string_view line = without_comment(whole);
        if (line.empty()) continue;
        if (is_open) {
            value += " " + std::string(line);
            end_value();
            continue;
        }
        if (line.front() == '[' && line.back() == ']') {
            const std::string_view name = trim(line.substr(1, line.size() - 2));
            if (!is_name(name)) return {};
            section = std::string(name) + ".";
            continue;
        }
        const std::size_t equals = line.find('=');
        const std::string_view name = trim(line.substr(0, equals));
        if (equals == std::string_view::npos || !is_name(name)) {
            if (entries.empty()) return {};
            is_shown = is_shown && append_shown(line, factor, entries.back().values);
            continue;  // words between the values, as people and programs add them
        }
        entries.push_back({section + std::string(name), {}});
        value = std::string(line.substr(equals + 1));
        is_shown = trim(value).empty();
        factor = 1;
        end_value();
    }
    if (is_open) refuse_key(source, entries.back().name, "has no closing bracket; the file is truncated");
    return entries;
}

}  // namespace hexrelief::readers::codec
