#include "exporters/core/file_names.h"

#include <algorithm>
#include <cctype>

#include "pipeline/data/error.h"

namespace hexrelief {

const std::vector<std::string>& export_extensions() {
    static const std::vector<std::string> extensions = {".glb", ".gltf", ".drc",  ".obj",
                                                        ".ply", ".stl",  ".usdz", ".html"};
    return extensions;
}

std::string format_name(MeshFormat format) {
    return export_extensions().at(static_cast<std::size_t>(format)).substr(1);
}

std::string extension_of(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

MeshFormat export_format(const std::filesystem::path& path) {
    const std::string extension = extension_of(path);
    const std::vector<std::string>& known = export_extensions();
    const auto found = std::find(known.begin(), known.end(), extension);
    if (found != known.end()) {
        const auto format = static_cast<MeshFormat>(found - known.begin());
        // Its .mtl and its texture are named in lines of text.
        if (format == MeshFormat::obj && path.filename().string().find_first_of("\r\n") != std::string::npos)
            throw Error(ErrorKind::usage,
                        "an OBJ file cannot name the files beside it where its own name, '" + path.string() +
                            "', has a line break; choose another name");
        return format;
    }
    std::string list;
    for (const std::string& one : known) list += (list.empty() ? "" : " ") + one;
    throw Error(ErrorKind::usage, "cannot tell the mesh format of '" + path.string() +
                                      "': its extension is '" + extension + "'; use one of " + list);
}

Compression compression_of(MeshFormat format, const ExportConfig& config) {
    switch (format) {
        case MeshFormat::glb:
        case MeshFormat::gltf:
            return config.compression;
        case MeshFormat::drc:
            return Compression::draco;
        case MeshFormat::html:
            return Compression::meshopt;
        default:
            return Compression::none;
    }
}

bool separate_levels(const std::filesystem::path& path, const ExportConfig& config) {
    const MeshFormat format = export_format(path);
    if (format == MeshFormat::html) return false;  // the page changes between them
    return config.lod_storage == LevelStorage::files ||
           (format != MeshFormat::glb && format != MeshFormat::gltf);
}

std::filesystem::path level_path(const std::filesystem::path& path, int level) {
    std::filesystem::path name = path.stem();
    name += ".lod" + std::to_string(level);
    name += path.extension();
    return path.parent_path() / name;
}

}  // namespace hexrelief
