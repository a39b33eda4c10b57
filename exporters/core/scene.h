// A scene to export and its export configuration.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::exporters {

// The mesh compression of .glb and .gltf. Files .drc are always Draco; other formats are never compressed.
enum class Compression { none, draco, quantized, meshopt };

// The bits of Draco's attributes; 0 = as many as the tolerances need.
struct DracoConfig {
    // The coder takes 0.2 GB for this many bits of any attribute, and four times that for
    // every two more bits.
    static constexpr int kMostBits = 24;
    int position_bits = 0;  // along the widest side of the mesh's bounding box
    int normal_bits = 0;
    int texcoord_bits = 0;
    int level = 10;  // 0 (fast) .. 10 (small)
};

// The storage of coarser levels of detail: a file each, or inside .glb and .gltf by MSFT_lod. Programs that
// do not know MSFT_lod show the coarser levels on top of the finest one.
enum class LevelStorage { files, inside };

// The unit of one number in an .stl file, which cannot state it.
enum class StlUnit { metre, millimetre };

// The place of a file's origin: the left camera, or below the middle of the mesh, as low as its lowest point,
// where programs that put models onto floors want it. automatic: base in .usdz.
enum class FileOrigin { automatic, camera, base };

// The axis that points up in .obj, .ply and in an .stl without a body. y: the camera looks along -Z, as in
// SurfaceMesh; z: along +Y, as programs for CAD and maps have it.
enum class UpAxis { y, z };
inline Vec3f placed(const Vec3f& v, UpAxis up) {
    return up == UpAxis::z ? Vec3f{v.x, -v.z, v.y} : v;
}
inline const char* axes_text(UpAxis up) {
    return up == UpAxis::z ? "+Z up, camera looking along +Y" : "+Y up, camera looking along -Z";
}

// The contents of .stl, .3mf, .glb and .gltf: the surface, or a body that stands on a flat base,
// or one of even thickness.
enum class SolidKind { none, base, shell };

// The material of the texture in glTF and USD. unlit: the photograph as it is, by KHR_materials_unlit; USD
// has no such material, so it emits the texture there. emissive: a black surface that emits the texture, for
// readers of glTF without that extension. lit: by the program's lights.
enum class MaterialKind { emissive, unlit, lit };

// automatic: normals are written if a program's lights fall on the mesh, that is, unless its material
// is emissive or unlit.
enum class NormalsKind { automatic, always, never };

// What vertices tell of where their depth comes from.
enum class ProvenanceKind { cameras, matches };

enum class TextureFormat { none, jpeg, png, webp };

// The field table of pipeline/config has the ranges.
struct ExportConfig {
    Compression compression = Compression::none;
    // Largest errors of compressed attributes. tolerance_px: of positions, projected back to the image, in x,
    // in y and in disparity, and of texture coordinates, in the texture's pixels. tolerance_deg: of normals.
    double tolerance_px = 0.1;
    // If above 0, the tolerance is at most this share of the surface's own error, which the caller of the
    // exporters works out; tolerance_px is then the upper limit.
    double tolerance_share = 0;
    double tolerance_deg = 1;
    NormalsKind normals = NormalsKind::automatic;
    MaterialKind material = MaterialKind::unlit;
    bool texcoords = true;  // false leaves the texture out as well, which cannot be mapped without them
    TextureFormat texture = TextureFormat::jpeg;
    int texture_quality = 90;  // for JPEG and WebP
    int texture_max_px = 0;    // longest side of the texture; 0 = unlimited
    bool texture_crop = true;  // crops the texture to the part that the mesh shows
    bool camera = true;        // writes the left camera to glTF if the image's size is known
    FileOrigin origin = FileOrigin::automatic;
    ProvenanceKind provenance = ProvenanceKind::cameras;
    std::string copyright = {};  // for glTF's asset.copyright; may be empty
    DracoConfig draco = {};
    StlUnit stl_unit = StlUnit::metre;
    UpAxis up = UpAxis::y;
    bool ply_texcoords = false;  // s t in .ply, which has no texture beside it
    SolidKind solid = SolidKind::none;
    double solid_size_mm = 100;  // longer side of the base
    int lod = 1;                 // number of levels of detail, the scene's mesh included
    LevelStorage lod_storage = LevelStorage::files;
};

// A picture that a page shows beside the relief.
struct PagePicture {
    std::string name;   // "relief" is shown in the relief's place if there is no WebGL
    std::string label;  // what the picture shows, in words
    Image image;
};
struct PageFigure {
    std::string name;
    double value = 0;
    int decimals = 0;
    std::string unit;  // may be empty
};
struct PageContent {
    std::vector<PagePicture> pictures;
    std::vector<PageFigure> figures;
};

// The contents of an exported file. If `texture` is null, no image and no texture coordinates are written.
struct Scene {
    const SurfaceMesh* mesh = nullptr;
    const Image* texture = nullptr;
    std::string generator;    // for asset.generator and file comments: "hexrelief 0.2.0"
    std::string extras_json;  // the effective parameters, a JSON object for glTF's asset.extras; may be empty
    // Needed to convert the tolerance in px; if null, compressed positions get 14 bits instead.
    const Calibration* camera = nullptr;
    std::vector<const SurfaceMesh*> coarser = {};  // the same surface with fewer and fewer vertices
    int threads = 1;                               // threads that may work at once; they change no byte
    int image_width = 0, image_height = 0;         // size of the left image, in which the camera is measured
    const PageContent* page = nullptr;             // contents of an .html page; null = the relief only
    // What is up in the mesh's xy plane, a unit vector: files hold the mesh turned about the camera's axis so
    // that this is +Y.
    std::array<double, 2> up = {0, 1};
    bool is_body = false;  // the meshes are closed: each side of a triangle is that of one other
    // If above 0, a power of two: all positions are multiples of it, of less than 2^24 steps, and every
    // file holds them exactly.
    double grid_step_m = 0;
    // Position of the mesh's own origin in space, a multiple of grid_step_m: the node's translation in .glb
    // and .gltf. Other formats ignore it.
    std::array<double, 3> origin_m = {};
    // Where all that a .glb or .gltf holds is moved to, by a node above it.
    std::array<double, 3> shift_m = {};
    // The file that the top left of the texture was read from, in JPEG, PNG or WebP; null = none. The texture
    // keeps what that file has if it takes hardly more bytes than one encoded anew (encode_texture()).
    const std::vector<std::uint8_t>* texture_file = nullptr;
};

}  // namespace hexrelief::exporters
