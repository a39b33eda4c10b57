// What is exported, and how it is to be held.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

// How .glb and .gltf hold the mesh; .drc is always Draco, .html always meshopt, the others never are
// compressed.
enum class Compression { none, draco, quantized, meshopt };

// Bits of 0 = as many as the tolerances ask for.
struct DracoConfig {
    int position_bits = 0;  // 1..30; of the widest side of the mesh's box
    int normal_bits = 0;    // 2..30
    int texcoord_bits = 0;  // 1..30
    int level = 10;         // 0 (fast) .. 10 (small)
};

// Coarser levels of detail: a file each, or inside .glb and .gltf by MSFT_lod, which programs that do not
// know it show on top of the finest one.
enum class LevelStorage { files, inside };

// Of one number in an .stl, which cannot say it.
enum class StlUnit { metre, millimetre };

// How glTF and USD show the texture. emissive: as light of its own, which is the photograph as it is in every
// program tried; unlit: KHR_materials_unlit, which VTK 9.1 shows as white; lit: by the program's lights.
enum class MaterialKind { emissive, unlit, lit };

// automatic: where a program's lights fall on the mesh, which they do not on an emissive or unlit material.
enum class NormalsKind { automatic, always, never };

enum class TextureFormat { none, jpeg, png, webp };

struct ExportConfig {
    Compression compression = Compression::none;
    // Largest errors of compressed attributes: of positions, projected back, in x, in y and in disparity; of
    // texture coordinates, in the texture's pixels; of normals.
    double tolerance_px = 0.1;
    // Where above 0, tolerance_px is only the most: less where so large a share of the surface's own error
    // is. The caller of the exporters works it out.
    double tolerance_share = 0;
    double tolerance_deg = 1;
    NormalsKind normals = NormalsKind::automatic;
    MaterialKind material = MaterialKind::emissive;
    bool texcoords = true;  // false leaves the texture out as well, where it cannot be mapped without them
    TextureFormat texture = TextureFormat::jpeg;
    int texture_quality = 90;  // 1..100, of JPEG and WebP
    int texture_max_px = 0;    // longest side of the texture; 0 = as it is
    bool texture_crop = true;  // to what the mesh shows
    bool camera = true;        // the left camera in glTF, where its image's size is known
    DracoConfig draco;
    StlUnit stl_unit = StlUnit::metre;
    int lod = 1;  // levels of detail, the scene's mesh included
    LevelStorage lod_storage = LevelStorage::files;
};

// What a page shows beside the relief.
struct PagePicture {
    std::string name;   // "relief" is shown in the relief's place where there is no WebGL
    std::string label;  // what it shows, in words
    Image image;
};
struct PageFigure {
    std::string name;
    double value = 0;
    int decimals = 0;
    std::string unit;  // empty = none
};
struct PageContent {
    std::vector<PagePicture> pictures;
    std::vector<PageFigure> figures;
};

// What is written. texture may be null: then no image and no texture coordinates are written.
struct Scene {
    const SurfaceMesh* mesh = nullptr;
    const Image* texture = nullptr;
    std::string generator;    // asset.generator and file comments: "hexrelief 0.1.0"
    std::string extras_json;  // a JSON object for glTF's asset.extras: the effective parameters; may be empty
    // What the tolerance in px is told by; null = compressed positions take 14 bits instead.
    const Calibration* camera = nullptr;
    std::vector<const SurfaceMesh*> coarser = {};  // the same surface with fewer and fewer vertices
    int threads = 1;                               // that may work on it at once; they change no byte
    int image_width = 0, image_height = 0;         // px of the left image, which the camera is measured in
    const PageContent* page = nullptr;             // of .html; null = the relief alone
    // Above 0, a power of two: all positions are whole multiples of it, of less than 2^24 steps, and every
    // file holds them exactly.
    double grid_step_m = 0;
    // Where the mesh's own origin lies in space, a multiple of that step: the node's translation in .glb and
    // .gltf, which alone take it.
    std::array<double, 3> origin_m = {};
};

}  // namespace hexrelief
