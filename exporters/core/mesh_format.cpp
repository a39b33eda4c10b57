#include "exporters/core/mesh_format.h"

#include <cctype>

namespace hexrelief::exporters {

std::string extension_of(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

std::filesystem::path level_path(const std::filesystem::path& path, int level) {
    std::filesystem::path name = path.stem();
    name += ".lod" + std::to_string(level);
    name += path.extension();
    return path.parent_path() / name;
}

}  // namespace hexrelief::exporters
