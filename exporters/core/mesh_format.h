// What a mesh format can do. Each format has one row, beside the function that writes it;
// exporters/mesh_formats.h has them all.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "exporters/core/file_transaction.h"
#include "exporters/core/scene.h"

namespace hexrelief::inspect {
struct MeshDescription;  // exporters/inspect/describe_mesh.h
}

namespace hexrelief::exporters {

// Puts its files into the transaction, path itself first, and throws Error(output). The scene has been
// checked, and its normals are always or never written (see exporters/exporter.cpp).
using FormatWriter = void (*)(const Scene&, const ExportConfig&, const std::filesystem::path&,
                              FileTransaction&);

// What shows the scene's picture.
enum class ColourStorage { none, vertices, texture };

// Where coarser levels of detail are; by_config: where export.lod_storage says.
enum class LevelSupport { files, by_config, inside };

struct MeshFormat {
    const char* extension;  // in lower case, with the dot
    const char* holds;      // for FORMATS.md
    FormatWriter write;
    // Reads a file of the format, for `hexrelief info`. Throws Error(input).
    inspect::MeshDescription (*describe)(const std::filesystem::path&);
    ColourStorage colours = ColourStorage::none;
    // export.material says how the texture is shown; programs' lights fall on the others.
    bool has_material = false;
    // How positions are held; nothing: as export.compression says.
    std::optional<Compression> compression = Compression::none;
    // Their tolerance, px; null: export.tolerance_px.
    double (*tolerance_px)(const Scene&, const ExportConfig&, const std::filesystem::path&) = nullptr;
    LevelSupport levels = LevelSupport::files;
    // Extension of a file beside the named one, with which a texture file goes; null: there is neither.
    const char* companion = nullptr;
    // The named file tells their names in lines of text, so that a line break would cut them.
    bool names_companions_in_lines = false;
    // Shows the relief and its figures, and needs a viewer and a camera.
    bool is_page = false;

    std::string name() const { return extension + 1; }
    Compression compression_in(const ExportConfig& config) const {
        return compression.value_or(config.compression);
    }
    bool has_separate_levels(const ExportConfig& config) const {
        return levels == LevelSupport::files ||
               (levels == LevelSupport::by_config && config.lod_storage == LevelStorage::files);
    }
};

}  // namespace hexrelief::exporters
