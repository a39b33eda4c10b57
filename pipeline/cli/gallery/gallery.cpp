#include "pipeline/cli/gallery/gallery.h"

#include <utility>
#include <vector>

#include "exporters/core/file_names.h"
#include "exporters/viewer/gallery_page.h"
#include "exporters/viewer/html_exporter.h"
#include "pipeline/cli/gallery/results.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"

namespace hexrelief::cli {
namespace {

namespace fs = std::filesystem;

const std::vector<exporters::GalleryColumn> kColumns = {{"Vertices", 0}, {"Triangles", 0}, {"Bytes", 0},
                                                        {"%cost", 2},    {"Error, px", 3}, {"Seconds", 2}};

exporters::GalleryEntry entry_of(FoundResult result, const fs::path& folder, const fs::path& place) {
    const auto& [vertices, triangles, bytes, percent_cost, error_px, seconds] = result.figures;
    fs::path name = fs::relative(result.file, folder);
    if (exporters::extension_of(name) == ".html") name.replace_extension();
    return {name.generic_string(),
            fs::relative(result.file, place),
            std::move(result.picture),
            {vertices, triangles, bytes, percent_cost, error_px, seconds}};
}

}  // namespace

std::size_t write_gallery(const fs::path& folder, const fs::path& path) {
    if (!exporters::has_viewer())
        throw Error(ErrorKind::usage, std::string("no gallery can be made: ") + exporters::kNoViewer);
    if (!fs::is_directory(folder))
        throw Error(ErrorKind::input, "cannot read '" + folder.string() + "': it is no folder");
    if (exporters::extension_of(path) != ".html")
        throw Error(ErrorKind::usage, "'" + path.string() + "': a gallery is a page; name a file .html");
    files::check_writable_file(path);
    std::vector<exporters::GalleryEntry> entries;
    for (FoundResult& result : find_results(folder)) {
        files::check_overwrites({path}, {result.file});
        entries.push_back(entry_of(std::move(result), folder, fs::absolute(path).parent_path()));
    }
    if (entries.empty())
        throw Error(ErrorKind::input, "'" + folder.string() +
                                          "' holds no result; hexrelief run -o a.html --report a.json "
                                          "writes what a gallery shows");
    const std::string title = fs::canonical(folder).filename().string();
    files::OutputSet outputs;
    outputs.place(path);
    outputs.files().write(path, exporters::gallery_page(title, kColumns, entries));
    outputs.commit();
    return entries.size();
}

}  // namespace hexrelief::cli
