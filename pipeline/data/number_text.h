// Formats numbers, sizes and lists for messages, replaces characters, and reads numbers from words.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace hexrelief {

// Returns the number with at most so many significant digits and no trailing zeros: "6", "713.26".
inline std::string number_text(double value, int digits = 9) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

// Returns the number with so many decimals: "6.00".
inline std::string fixed(double value, int decimals) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    return text;
}

// Returns a picture's sides: "640x480".
template <typename Side>
std::string size_text(Side width, Side height, const char* between = "x") {
    return std::to_string(width) + between + std::to_string(height);
}

// Returns the items' texts with a separator between them. text_of: a function or a member of an item.
template <typename Items, typename TextOf = std::identity>
std::string joined(const Items& items, std::string_view separator, const TextOf& text_of = {}) {
    std::string text;
    for (const auto& item : items)
        text.append(text.empty() ? "" : separator).append(std::invoke(text_of, item));
    return text;
}

inline std::string replaced(std::string_view text, char from, std::string_view to) {
    std::string changed;
    for (const char c : text) changed += c == from ? to : std::string_view(&c, 1);
    return changed;
}

// Returns the whole text as a number of digits alone; nullopt for any other text.
inline std::optional<std::size_t> whole_number(std::string_view text) {
    std::size_t value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace hexrelief
