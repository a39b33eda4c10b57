// Text that is put into a page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hexrelief::exporters {

std::string base64(const std::vector<std::uint8_t>& bytes);

// As the text of an element or the value of an attribute.
std::string html_escaped(std::string_view text);

// A relative path as a link: percent-encoded but for slashes.
std::string link_to(const std::filesystem::path& path);

// JSON that nothing in a script element can end.
std::string script_escaped(const std::string& json);

// The page with each mark replaced by its value, once each. The marks stand in the page in the order given;
// what a value holds is not searched. Throws std::logic_error where one is missing.
std::string filled(std::string_view page,
                   const std::vector<std::pair<std::string_view, std::string_view>>& values);

}  // namespace hexrelief::exporters
