// Converts text for use in a page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hexrelief::exporters {

std::string base64(const std::vector<std::uint8_t>& bytes);

// Escapes text for an element or for the value of an attribute.
std::string html_escaped(std::string_view text);

// Converts a relative path to a link: percent-encoded except for slashes.
std::string link_to(const std::filesystem::path& path);

// Escapes JSON so that nothing in it can end a script element.
std::string script_escaped(const std::string& json);

// Returns the page with each mark replaced by its value, once per entry. The marks must appear in the page in
// the given order; values are not searched for marks. Throws std::logic_error if a mark is missing.
std::string filled(std::string_view page,
                   const std::vector<std::pair<std::string_view, std::string_view>>& values);

}  // namespace hexrelief::exporters
