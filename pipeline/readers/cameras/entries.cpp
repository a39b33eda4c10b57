#include "pipeline/readers/cameras/entries.h"

#include <algorithm>
#include <array>
#include <cctype>

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
    const bool is_camera =
        std::find(kNumberedNames.begin(), kNumberedNames.end(), stem) != kNumberedNames.end();
    return is_camera ? component.back() - '0' : -1;
}

template <typename Names>
bool is_one_of(const Names& names, const std::string& component) {
    return std::find(names.begin(), names.end(), component) != names.end();
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

}  // namespace hexrelief::readers::codec
