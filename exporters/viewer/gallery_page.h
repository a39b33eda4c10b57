// A page that lists results, with a picture and figures of each, to be sorted and opened.
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
    std::filesystem::path link;  // to the result, relative to the gallery's folder
    std::string picture;         // a data: address, as small_picture() gives; empty = none
    std::vector<double> values;  // one a column; NaN = not known
};

// Throws Error(output) where the program was built without its viewer (html_exporter.h).
std::string gallery_page(const std::string& title, const std::vector<GalleryColumn>& columns,
                         const std::vector<GalleryEntry>& entries);

}  // namespace hexrelief::exporters
