// Builds a page that lists results, with a picture and figures of each; they can be sorted and opened.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::exporters {

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

// Returns the page. Throws Error(output) if the program was built without its viewer (html_exporter.h).
std::string gallery_page(const std::string& title, const std::vector<GalleryColumn>& columns,
                         const std::vector<GalleryEntry>& entries);

}  // namespace hexrelief::exporters
