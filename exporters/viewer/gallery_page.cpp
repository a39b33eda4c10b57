#include "exporters/viewer/gallery_page.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "exporters/viewer/html_exporter.h"
#include "exporters/viewer/html_text.h"
#include "exporters/viewer/viewer_page.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

std::string printed(double value, int decimals) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    std::string out = text;
    // Thousands are separated by a narrow no-break space.
    const std::size_t point = std::min(out.find('.'), out.size());
    for (std::size_t at = point; at > 3 && std::isdigit(static_cast<unsigned char>(out[at - 4]));) {
        at -= 3;
        out.insert(at, "\u202f");
    }
    return out;
}

std::string head(const std::string& name) {
    return "<th scope=\"col\"><button>" + html_escaped(name) + "</button></th>";
}

std::string row(const std::vector<GalleryColumn>& columns, const GalleryEntry& entry) {
    std::string out = "<tr><td><a href=\"" + html_escaped(link_to(entry.link)) + "\">";
    if (!entry.picture.empty()) out += "<img alt=\"\" src=\"" + html_escaped(entry.picture) + "\">";
    out += html_escaped(entry.name) + "</a></td>";
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const double value = entry.values.at(i);
        out += "<td data-name=\"" + html_escaped(columns[i].name) + "\"";
        if (std::isfinite(value)) {
            char exact[64];
            std::snprintf(exact, sizeof exact, "%.17g", value);
            out += std::string(" data-value=\"") + exact + "\">" + printed(value, columns[i].decimals);
        } else {
            out += ">–";
        }
        out += "</td>";
    }
    return out + "</tr>\n";
}

}  // namespace

std::string gallery_page(const std::string& title, const std::vector<GalleryColumn>& columns,
                         const std::vector<GalleryEntry>& entries) {
    if (!has_viewer()) throw Error(ErrorKind::output, std::string("no gallery can be made: ") + kNoViewer);
    const std::string text = html_escaped(title);
    std::string heads = head("Result"), rows;
    for (const GalleryColumn& column : columns) heads += head(column.name);
    for (const GalleryEntry& entry : entries) rows += row(columns, entry);
    return filled(empty_gallery(),
                  {{"@title@", text}, {"@title@", text}, {"@columns@", heads}, {"@rows@", rows}});
}

}  // namespace hexrelief::exporters
