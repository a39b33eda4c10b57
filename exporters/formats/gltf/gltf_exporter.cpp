#include "exporters/formats/gltf/gltf_exporter.h"

#include <limits>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/gltf/model.h"
#include "exporters/images/texture.h"
#include "exporters/inspect/describe_formats.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

void append_u32(std::vector<std::uint8_t>& bytes, std::size_t value) {
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

// Appends one chunk of a GLB, padded to a multiple of 4.
template <typename Container>
void append_chunk(std::vector<std::uint8_t>& bytes, const char* type, const Container& data, char filler) {
    append_u32(bytes, (data.size() + 3) / 4 * 4);
    bytes.insert(bytes.end(), type, type + 4);
    bytes.insert(bytes.end(), data.begin(), data.end());
    bytes.resize((bytes.size() + 3) / 4 * 4, static_cast<std::uint8_t>(filler));
}

}  // namespace

std::vector<std::uint8_t> glb_bytes(const Scene& scene, const ExportConfig& config,
                                    const std::filesystem::path& path) {
    const GltfDocument document = build_gltf(scene, config, {});
    constexpr std::size_t kHeader = 12, kChunkHeader = 8;
    const std::size_t size = kHeader + kChunkHeader + (document.json.size() + 3) / 4 * 4 + kChunkHeader +
                             (document.buffer.size() + 3) / 4 * 4;
    if (size > std::numeric_limits<std::uint32_t>::max()) {
        throw Error(ErrorKind::output,
                    "cannot write '" + path.string() +
                        "': a GLB ends at 4 GiB; set export.compression to draco or write .gltf");
    }
    std::vector<std::uint8_t> bytes;
    bytes.reserve(size);
    for (const char c : {'g', 'l', 'T', 'F'}) bytes.push_back(static_cast<std::uint8_t>(c));
    append_u32(bytes, 2);
    append_u32(bytes, size);
    append_chunk(bytes, "JSON", document.json, ' ');
    append_chunk(bytes, "BIN\0", document.buffer, '\0');
    return bytes;
}

namespace {

void write_glb(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    files.write(path, glb_bytes(scene, config, path));
}

void write_gltf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files) {
    std::filesystem::path buffer_path = path;
    buffer_path.replace_extension(".bin");
    const std::filesystem::path image_path = texture_path(path, config);
    const GltfDocument document =
        build_gltf(scene, config, {buffer_path.filename().string(), image_path.filename().string()});
    files.write(path, document.json + "\n");
    files.write(buffer_path, document.buffer);
    if (!document.texture.bytes.empty()) files.write(image_path, document.texture.bytes);
}

}  // namespace

extern const MeshFormat glb_format = {
    .extension = ".glb",
    .holds = "glTF 2.0 in one file, with JPEG, PNG or WebP texture",
    .write = write_glb,
    .describe = inspect::describe_glb,
    .colours = ColourStorage::texture,
    .has_material = true,
    .compression = std::nullopt,
    .levels = LevelSupport::by_config,
    .origin = OriginSupport::node,
    .body_unit_mm = 1000,
};

extern const MeshFormat gltf_format = {
    .extension = ".gltf",
    .holds = "the same, with `.bin` and texture beside",
    .write = write_gltf,
    .describe = inspect::describe_gltf,
    .colours = ColourStorage::texture,
    .has_material = true,
    .compression = std::nullopt,
    .levels = LevelSupport::by_config,
    .origin = OriginSupport::node,
    .body_unit_mm = 1000,
    .companion = ".bin",
};

}  // namespace hexrelief::exporters
