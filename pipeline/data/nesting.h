// How deeply brackets are nested in text that others wrote.
#pragma once

#include <string_view>

namespace hexrelief {

// No file of this program's, and no glTF file, is nested as deeply.
inline constexpr int kDeepestNesting = 100;

// True if the arrays and objects of a JSON text are nested deeper than kDeepestNesting. Parsers, and even
// copies of what they parsed, call themselves once for each level: a file of a few kilobytes could exhaust
// the stack.
inline bool is_nested_too_deeply(std::string_view json) {
    int depth = 0;
    bool is_quoted = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char letter = json[i];
        if (letter == '"') is_quoted = !is_quoted;
        if (is_quoted) {
            if (letter == '\\') ++i;
        } else if (letter == '[' || letter == '{') {
            if (++depth > kDeepestNesting) return true;
        } else if (letter == ']' || letter == '}') {
            --depth;
        }
    }
    return false;
}

}  // namespace hexrelief
