// The abilities of mesh formats, and the names of formats and of the files that they consist of. Each format
// has one row of abilities, beside the function that writes it; exporters/exporter.cpp lists all rows.
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

// Puts the format's files into the transaction, path itself first. Throws Error(output). The scene has been
// checked, and its normals are always or never written (see exporters/exporter.cpp).
using FormatWriter = void (*)(const Scene&, const ExportConfig&, const std::filesystem::path&,
                              FileTransaction&);

// The part of a file that holds the picture's colours.
enum class ColourStorage { none, vertices, texture };

// How a file's origin is moved: by other positions, or by a node above all. none: it is not.
enum class OriginSupport { none, positions, node };

// The place of coarser levels of detail; by_config: as export.lod_storage says.
enum class LevelSupport { files, by_config, inside };

struct MeshFormat {
    const char* extension;  // in lower case, with the dot
    const char* holds;      // for FORMATS.md
    FormatWriter write;
    // Reads a file of the format, for `hexrelief info`. Throws Error(input).
    inspect::MeshDescription (*describe)(const std::filesystem::path&);
    ColourStorage colours = ColourStorage::none;
    // True if export.material sets the texture's material. Viewers light the formats without a material.
    bool has_material = false;
    // Compression of positions; none: as export.compression says.
    std::optional<Compression> compression = Compression::none;
    // Returns the tolerance of positions, px; null: export.tolerance_px.
    double (*tolerance_px)(const Scene&, const ExportConfig&, const std::filesystem::path&) = nullptr;
    LevelSupport levels = LevelSupport::files;
    OriginSupport origin = OriginSupport::none;
    FileOrigin usual_origin = FileOrigin::camera;  // of export.origin: auto
    // What 1 means in files of a body (export.solid), mm; 0 = the format holds the surface alone.
    double body_unit_mm = 0;
    // Extension of a companion file, which comes with a texture file; null: the format has neither.
    const char* companion = nullptr;
    // True if the file names its companions in lines of text, which a line break in a name would cut.
    bool names_companions_in_lines = false;
    // True if the file shows the relief and its figures; it then needs a viewer and a camera.
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

// Returns the extension in lower case, with the dot.
std::string extension_of(const std::filesystem::path& path);

// Returns the path of a level of detail in a file of its own: "<stem>.lod<level><extension>", level >= 1.
std::filesystem::path level_path(const std::filesystem::path& path, int level);

}  // namespace hexrelief::exporters
