// Parses numbers and words from text that people and tools write; independent of the locale.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hexrelief::readers::codec {

// True of blanks, tabulators and line ends in the C locale.
constexpr bool is_space(unsigned char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

std::string_view trim(std::string_view text);

// Returns the words between white space; commas count as white space.
std::vector<std::string_view> words(std::string_view text);

// Returns the lines without their ends (LF, CRLF or CR).
std::vector<std::string_view> lines(std::string_view text);

// Returns the text with the letters A to Z small.
std::string lower_case(std::string text);

// Returns the whole text as a finite number; nullopt otherwise ("nan", "inf", trailing letters, nothing).
std::optional<double> parse_number(std::string_view text);

// Returns text for an error message: printable, at most 40 characters, in quotes.
std::string excerpt(std::string_view text);

// Returns printable text without quotes, at most `longest` characters and "..." if it was longer.
std::string printable(std::string_view text, std::size_t longest);

}  // namespace hexrelief::readers::codec
