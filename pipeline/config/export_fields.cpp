// The rows of the field table for the files that are written.
#include "pipeline/config/field_makers.h"

namespace hexrelief::config {

std::vector<Field> export_fields() {
    return {
        choice("export.compression", MEMBER(exporting.compression), {"none", "draco", "quantized", "meshopt"},
               "of .glb and .gltf: KHR_draco_mesh_compression, KHR_mesh_quantization, "
               "EXT_meshopt_compression; .drc is always Draco"),
        number("export.tolerance_px", MEMBER(exporting.tolerance_px), "px", {0.001, 100},
               "largest error of compressed positions, seen by the camera, in x, y and disparity, and of "
               "texture coordinates in the texture"),
        number("export.tolerance_share", MEMBER(exporting.tolerance_share), "", {0, 100},
               "above 0, tolerance_px is lowered to this share of the surface's own error away from "
               "discontinuities (surface.flat_rmse_px); 0 = it is not"),
        number("export.tolerance_deg", MEMBER(exporting.tolerance_deg), "deg", {0.01, 30},
               "largest error of compressed normals"),
        choice("export.material", MEMBER(exporting.material), {"emissive", "unlit", "lit"},
               "how .glb, .gltf and .usdz show the texture: unlit = as it is, by KHR_materials_unlit, which "
               "VTK 9.1 and f3d 1.3 show white; emissive = as light of its own, right there, but black in "
               "CesiumJS and too bright in model-viewer; lit = by the program's lights"),
        choice("export.normals", MEMBER(exporting.normals), {"auto", "always", "never"},
               "auto = where lights fall on the mesh: not in .glb, .gltf and .usdz with a texture that is "
               "emissive or unlit; programs make their own where there are none"),
        flag("export.texcoords", MEMBER(exporting.texcoords),
             "write texture coordinates; without them .glb, .gltf and .obj have no texture"),
        choice(
            "export.texture", MEMBER(exporting.texture), {"none", "jpeg", "png", "webp"},
            "image on the surface; webp is EXT_texture_webp in glTF; none also leaves a .ply's colours out"),
        number("export.texture_quality", MEMBER(exporting.texture_quality), "", {1, 100},
               "of a JPEG or WebP texture; a JPEG keeps its own file's blocks for up to 4/3 of the bytes"),
        number("export.texture_max_px", MEMBER(exporting.texture_max_px), "px", {0, 65500},
               "longest side of the texture, larger ones are scaled down; 0 = as large as it is"),
        flag("export.texture_crop", MEMBER(exporting.texture_crop),
             "crop the texture to what the mesh shows"),
        flag("export.camera", MEMBER(exporting.camera),
             "the left camera in .glb and .gltf, so that viewers can start at the photograph"),
        choice("export.origin", MEMBER(exporting.origin), {"auto", "camera", "base"},
               "where files have their origin: camera = the left camera; base = below the middle of the "
               "mesh, as low as its lowest point; auto = base in .usdz, which phones put onto the floor; "
               ".drc, .stl, .3mf and .html always have the camera's"),
        text("export.copyright", MEMBER(exporting.copyright),
             "of the photograph or the mesh, for .glb and .gltf"),
        choice("export.stl_unit", MEMBER(exporting.stl_unit), {"m", "mm"},
               "what 1 means in an .stl, which cannot say it; slicers take it for mm"),
        choice("export.up", MEMBER(exporting.up), {"y", "z"},
               "axis that points up in .obj, .ply and an .stl without a body; z is for programs of CAD and "
               "maps; the other formats have one of their own"),
        flag("export.ply_texcoords", MEMBER(exporting.ply_texcoords),
             "texture coordinates s, t in .ply, t = 0 at the bottom, of the texture that an .obj has with "
             "export.texture_crop=false"),
        choice("export.solid", MEMBER(exporting.solid), {"none", "base", "shell"},
               "contents of .stl, .3mf, .glb and .gltf: none = the surface; base = a closed body on a flat "
               "base, for printing; shell = one as thick everywhere; of the left view only, in mm where the "
               "format has them"),
        number("export.solid_size_mm", MEMBER(exporting.solid_size_mm), "mm", {10, 10000},
               "longer side of that base"),
        number("export.lod", MEMBER(exporting.lod), "", {1, 8},
               "levels of detail, each of twice the spacing of the one before; 1 = the mesh alone"),
        choice("export.lod_storage", MEMBER(exporting.lod_storage), {"files", "inside"},
               "coarser levels: files = NAME.lod1.glb and so on; inside = in one .glb or .gltf by MSFT_lod, "
               "which Blender and others do not know: they show all levels on top of each other"),
        optional_integer("export.draco.position_bits", MEMBER(exporting.draco.position_bits), "bit",
                         {1, exporters::DracoConfig::kMostBits},
                         "quantisation of positions; null = by tolerance_px"),
        optional_integer("export.draco.normal_bits", MEMBER(exporting.draco.normal_bits), "bit",
                         {2, exporters::DracoConfig::kMostBits},
                         "quantisation of normals; null = by tolerance_deg"),
        optional_integer("export.draco.texcoord_bits", MEMBER(exporting.draco.texcoord_bits), "bit",
                         {1, exporters::DracoConfig::kMostBits},
                         "quantisation of texture coordinates; null = by tolerance_px"),
        number("export.draco.level", MEMBER(exporting.draco.level), "", {0, 10}, "0 = fast, 10 = small"),
    };
}
}  // namespace hexrelief::config
