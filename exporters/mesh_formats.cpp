#include "exporters/mesh_formats.h"

#include <algorithm>

#include "exporters/core/file_names.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {

// The rows of the formats, each defined beside its writer.
extern const MeshFormat glb_format, gltf_format, drc_format, obj_format, ply_format, stl_format,
    threemf_format, usdz_format, html_format;

const std::vector<const MeshFormat*>& mesh_formats() {
    static const std::vector<const MeshFormat*> all = {&glb_format,     &gltf_format, &drc_format,
                                                       &obj_format,     &ply_format,  &stl_format,
                                                       &threemf_format, &usdz_format, &html_format};
    return all;
}

std::string export_extensions() {
    std::string list;
    for (const MeshFormat* format : mesh_formats())
        list.append(list.empty() ? "" : " ").append(format->extension);
    return list;
}

const MeshFormat* find_mesh_format(const std::filesystem::path& path) {
    const std::string extension = extension_of(path);
    const auto& all = mesh_formats();
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const MeshFormat* format) { return format->extension == extension; });
    return found == all.end() ? nullptr : *found;
}

const MeshFormat& export_format(const std::filesystem::path& path) {
    const MeshFormat* format = find_mesh_format(path);
    if (!format)
        throw Error(ErrorKind::usage, "cannot tell the mesh format of '" + path.string() +
                                          "': its extension is '" + extension_of(path) + "'; use one of " +
                                          export_extensions());
    if (format->names_companions_in_lines &&
        path.filename().string().find_first_of("\r\n") != std::string::npos) {
        std::string name = format->name();
        for (char& letter : name)
            letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
        throw Error(ErrorKind::usage, "an " + name +
                                          " file cannot name the files beside it where its own name, '" +
                                          path.string() + "', has a line break; choose another name");
    }
    return *format;
}

inspect::MeshDescription describe_mesh(const std::filesystem::path& path) {
    const MeshFormat& format = export_format(path);
    inspect::MeshDescription out = format.describe(path);
    out.format = format.name();
    return out;
}

}  // namespace hexrelief::exporters
