#include "pipeline/cli/info/told_lines.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "pipeline/cli/terminal/printable.h"

namespace hexrelief::cli::info {

void line(Text& text, const std::string& name, const std::string& words) {
    text.push_back({name, words, words});
}
void line(Text& text, const std::string& name, const std::string& words, Json value) {
    text.push_back({name, words, std::move(value)});
}
void count(Text& text, const std::string& name, long long number) {
    line(text, name, std::to_string(number), number);
}

void lines(Text& text, const std::string& name, const std::vector<std::string>& values) {
    for (const std::string& value : values) text.push_back({name, value, value, true});
}

std::string told(const Text& text, bool json) {
    std::string words, above;
    Json object = Json::object();
    for (const auto& [name, value_words, value, is_of_list] : text) {
        std::string label = is_of_list && name == above ? "" : name, key = name;
        label.resize(std::max<std::size_t>(label.size(), 14), ' ');
        words += label + printable(value_words) + "\n";
        std::replace(key.begin(), key.end(), ' ', '_');
        if (is_of_list)
            object[key].push_back(value);
        else
            object[key] = value;
        above = name;
    }
    return json ? object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n" : words;
}

Json size_json(int width, int height) {
    return {{"width", width}, {"height", height}};
}

std::string number(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.6g", value);
    return digits;
}

}  // namespace hexrelief::cli::info
