#include "pipeline/readers/parse_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace hexrelief::readers::codec {
namespace {

constexpr std::string_view kSpace = " \t\r\n\v\f";

}  // namespace

std::string_view trim(std::string_view text) {
    const std::size_t first = text.find_first_not_of(kSpace);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::vector<std::string_view> words(std::string_view text) {
    constexpr std::string_view separators = " \t\r\n\v\f,";
    std::vector<std::string_view> found;
    for (std::size_t at = text.find_first_not_of(separators); at != std::string_view::npos;) {
        const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
        found.push_back(text.substr(at, end - at));
        at = text.find_first_not_of(separators, end);
    }
    return found;
}

std::vector<std::string_view> lines(std::string_view text) {
    std::vector<std::string_view> found;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
        found.push_back(text.substr(0, end));
        const bool pair = text.substr(end, 2) == "\r\n";
        text.remove_prefix(std::min(end + (pair ? 2 : 1), text.size()));
    }
    return found;
}

std::string lower_case(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

std::optional<double> parse_number(std::string_view text) {
    text = trim(text);
    if (text.starts_with('+') && !text.starts_with("+-"))
        text.remove_prefix(1);  // from_chars takes no plus sign
    double value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::string excerpt(std::string_view text) {
    std::string shown = printable(text, 40);  // not one sum: GCC 12 falsely warns of an overlap there
    shown.insert(shown.begin(), '\'');
    return shown += '\'';
}

std::string printable(std::string_view text, std::size_t longest) {
    std::string shown;
    for (char c : text.substr(0, longest)) shown += c >= 0x20 && c < 0x7f ? c : '?';
    return shown + (text.size() > longest ? "..." : "");
}

}  // namespace hexrelief::readers::codec
