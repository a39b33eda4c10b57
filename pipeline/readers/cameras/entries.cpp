#include "pipeline/readers/cameras/entries.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/npz_codec.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

// The names of the cameras' sections: a digit may follow those of the second list.
constexpr std::array kLeftNames = {"left", "leftcam", "leftcamera", "cameraleft", "camleft"};
constexpr std::array kRightNames = {"right", "rightcam", "rightcamera", "cameraright", "camright"};
constexpr std::array kNumberedNames = {"cam", "camera", "cameraparameters"};

std::vector<std::string> components_of(const std::string& name) {
    std::vector<std::string> components;
    for (std::size_t at = 0; at <= name.size();) {
        const std::size_t end = std::min(name.find('.', at), name.size());
        components.push_back(plain_name(std::string_view(name).substr(at, end - at)));
        at = end + 1;
    }
    return components;
}

// Returns the camera's number in "cam0"; -1 for any other name.
int number_of_camera(const std::string& component) {
    if (component.empty() || component.back() < '0' || component.back() > '9') return -1;
    const std::string_view stem = std::string_view(component).substr(0, component.size() - 1);
    const bool is_camera = std::ranges::find(kNumberedNames, stem) != kNumberedNames.end();
    return is_camera ? component.back() - '0' : -1;
}

template <typename Names>
bool is_one_of(const Names& names, const std::string& component) {
    return std::ranges::find(names, component) != names.end();
}

constexpr std::uint64_t kMostBytes = 1u << 20;
constexpr std::string_view kEnding = ".npy";

// False for arrays of text, of Python's objects or of pixels, which calibrations hold besides.
bool has_numbers(const std::vector<std::uint8_t>& bytes) {
    const std::string_view head(reinterpret_cast<const char*>(bytes.data()),
                                std::min<std::size_t>(bytes.size(), 128));
    const std::size_t at = head.find("'descr': '");
    return at == std::string_view::npos || at + 11 >= head.size() || head[at + 11] == 'f' ||
           head[at + 11] == 'i';
}

bool is_name(std::string_view text) {
    return !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
           std::ranges::all_of(text, [](char c) {
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

std::string plain_name(std::string_view name) {
    std::string plain;
    for (const char c : name)
        if (c != '_' && c != '-' && c != ' ')
            plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

void name_sides(Entries& entries) {
    bool counts_from_0 = false;
    for (const Entry& entry : entries)
        for (const std::string& component : components_of(entry.name))
            counts_from_0 |= number_of_camera(component) == 0;
    const int first = counts_from_0 ? 0 : 1;
    std::erase_if(entries, [&](Entry& entry) {
        bool is_third = false;
        entry.key.clear();
        for (const std::string& component : components_of(entry.name)) {
            const int number = number_of_camera(component);
            if (number == first || is_one_of(kLeftNames, component))
                entry.side = Side::left;
            else if (number == first + 1 || is_one_of(kRightNames, component))
                entry.side = Side::right;
            else if (number >= 0)
                is_third = true;
            else
                entry.key += (entry.key.empty() ? "" : ".") + component;
        }
        return is_third;
    });
}

Entries read_entries(const CalibrationText& source) {
    Entries entries = xml_entries(source);
    if (entries.empty()) entries = assigned_entries(source);
    if (entries.empty()) entries = yaml_entries(source);
    name_sides(entries);
    return entries;
}

std::vector<double> numbers_of(const CalibrationText& source, const Entry& entry) {
    std::vector<double> numbers;
    for (const std::string& value : entry.values)
        numbers.push_back(require_number(source, entry.name, value));
    return numbers;
}

Entries npz_entries(const std::filesystem::path& path) {
    const SourceFile archive = load_file(path, kMostBytes);
    Entries entries;
    std::uint64_t all_bytes = 0;
    for (const ZipMember& member : list_members(archive)) {
        if (!member.name.ends_with(kEnding)) continue;
        const std::string name = member.name.substr(0, member.name.size() - kEnding.size());
        // Lists of the calibration's points go with it; they are longer than any of its numbers.
        constexpr std::uint64_t longest = 4096;
        all_bytes += member.bytes;
        if (member.bytes > longest || all_bytes > kMostBytes) continue;
        const SourceFile array{path.string() + ":" + printable(name, 40), unpack(archive, member, longest)};
        if (!has_numbers(array.bytes)) continue;
        Entry entry{name, {}};
        for (const double number : read_npy_numbers(array)) entry.values.push_back(exact_text(number));
        entries.push_back(std::move(entry));
    }
    name_sides(entries);
    return entries;
}

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
