// Exports a page that shows the relief in a browser: a single file that loads nothing else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::exporters {

std::string base64(const std::vector<std::uint8_t>& bytes);

// Escapes text for an element or for the value of an attribute.
std::string html_escaped(std::string_view text);

// Escapes JSON so that nothing in it can end a script element.
std::string script_escaped(const std::string& json);

// Returns the page with each mark replaced by its value, once per entry. The marks must appear in the page in
// the given order; values are not searched for marks. Throws std::logic_error if a mark is missing.
std::string filled(std::string_view page,
                   const std::vector<std::pair<std::string_view, std::string_view>>& values);

// Returns the data: URL of a WebP file of at most about 16 kB, shrunk and compressed as far as needed.
std::string small_picture(const Image& image);

// False if the program was built without node.js and npm; write_html() then throws an Error
// with the text kNoViewer.
bool has_viewer();
inline constexpr const char* kNoViewer =
    "this hexrelief was built without its viewer; install nodejs and npm and build it again, or write .glb";

struct GalleryColumn {
    std::string name;
    int decimals = 0;
};

struct GalleryEntry {
    std::string name;
    std::filesystem::path link;  // path of the result, relative to the gallery's folder
    std::string picture;         // a data: URL, as small_picture() returns it; may be empty
    std::vector<double> values;  // one per column; NaN = unknown
};

// Returns the page. Throws Error(output) if the program was built without its viewer.
std::string gallery_page(const std::string& title, const std::vector<GalleryColumn>& columns,
                         const std::vector<GalleryEntry>& entries);

}  // namespace hexrelief::exporters
