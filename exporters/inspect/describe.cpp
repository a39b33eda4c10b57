#include "exporters/inspect/describe.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "exporters/compression/draco_codec.h"
#include "exporters/core/file_names.h"
#include "exporters/inspect/describe_formats.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

std::vector<std::uint8_t> read_file(const fs::path& path) {
    constexpr std::uintmax_t kLargest = std::uintmax_t{2} << 30;
    std::error_code code;
    const fs::file_status status = fs::status(path, code);
    if (!fs::exists(status)) fail_reading(path, code ? code.message() : "no such file");
    if (!fs::is_regular_file(status)) fail_reading(path, "it is not a regular file");
    const std::uintmax_t size = fs::file_size(path, code);
    if (code) fail_reading(path, code.message());
    if (size == 0) fail_reading(path, "the file is empty");
    if (size > kLargest) fail_reading(path, "it is larger than 2 GiB");
    errno = 0;
    std::ifstream stream(path, std::ios::binary);
    if (!stream) fail_reading(path, std::strerror(errno));
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (stream.gcount() != static_cast<std::streamsize>(size))
        fail_reading(path, "it ended while being read");
    return bytes;
}

MeshDescription describe_drc(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
    const DracoSummary summary = summarise_draco(bytes, path.string());
    MeshDescription out;
    out.vertices = summary.vertices;
    out.triangles = summary.triangles;
    out.normals = summary.normals;
    out.texcoords = summary.texcoords;
    out.colors = summary.colors;
    out.compression = "draco";
    out.geometry_bytes.emplace_back("Draco", static_cast<long long>(bytes.size()));
    out.has_bounds = summary.has_bounds;
    out.min = summary.min;
    out.max = summary.max;
    return out;
}

MeshDescription describe(MeshFormat format, const fs::path& path, const std::vector<std::uint8_t>& bytes) {
    switch (format) {
        case MeshFormat::glb:
            return describe_gltf(path, bytes, true);
        case MeshFormat::gltf:
            return describe_gltf(path, bytes, false);
        case MeshFormat::drc:
            return describe_drc(path, bytes);
        case MeshFormat::obj:
            return describe_obj(path, bytes);
        case MeshFormat::ply:
            return describe_ply(path, bytes);
        case MeshFormat::stl:
            return describe_stl(path, bytes);
        case MeshFormat::usdz:
            return describe_usdz(path, bytes);
        case MeshFormat::html:
            return describe_html(path, bytes);
    }
    throw std::logic_error("no description of a mesh format");
}

}  // namespace

MeshDescription describe_mesh(const fs::path& path) {
    const MeshFormat format = export_format(path);
    MeshDescription out = describe(format, path, read_file(path));
    out.format = format_name(format);
    return out;
}

}  // namespace hexrelief
