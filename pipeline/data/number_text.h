// Formats numbers for messages, and reads them from words.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdio>
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

// Returns the whole text as a number of digits alone; nullopt for any other text.
inline std::optional<std::size_t> whole_number(std::string_view text) {
    std::size_t value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace hexrelief
