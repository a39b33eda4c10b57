// The rows of the field table for what is read and what is written.
#include "pipeline/config/field_makers.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::config {
namespace {

// Of the keys that maps of disparities and of depths have alike.
constexpr const char* kPackedHelp =
    "red, green and blue of the map's picture are one number; carla = 24 bits, red the lowest, of "
    "up to 1000 m; sintel = 4 red + green / 64 + blue / 16384 px; tartanair = the bits of a "
    "float, alpha the highest, m";
constexpr const char* kKeyHelp =
    "array of an NPZ, channel of an EXR that is the map; empty = the only one, or the usual names";
constexpr const char* kFlipHelp =
    "the map's rows are stored in the other order, as in a PFM with the top row first";

}  // namespace

std::vector<Field> input_fields() {
    return {
        choice(KEY(input.rectify), {"auto", "always", "never", "calibration"},
               "a pair's rows made the same: auto = by its calibration file, or without one by the points "
               "that both pictures show, if their rows are off; always = by the points, however little they "
               "are off; never = the pair as it is; calibration = only by the file",
               {"--rectify"}),
        flag(KEY(input.exif_orientation),
             "pictures are turned as their EXIF orientation says; a map's picture only if that makes it fit"),
        number(KEY(input.disparity.scale), "1/px", readers::DisparityFileConfig::kScale,
               "a supplied map's samples divided by this are px, -1 turns their sign; 0 = not given, then "
               "KITTI's 256 for 16-bit maps, StereoSGBM's 16 for its signed ones, 1 for float maps, and an "
               "error for others",
               {"--disparity-scale", "S"}),
        number(KEY(input.disparity.offset_px), "px", readers::DisparityFileConfig::kOffset_px,
               "added to a supplied map's disparities after the scale", {"--disparity-offset", "PX"}),
        optional(KEY(input.disparity.unknown), "", {-kAny, kAny},
                 "sample that means 'not known'; null = the map's own: the least value below 0 if it stands "
                 "alone, and 0 if none is below; inf, NaN and a TIFF's nodata always do",
                 {"--unknown", "V"}),
        text(KEY(input.disparity.key), kKeyHelp, {"--key", "NAME"}),
        choice("input.disparity.packed", MEMBER(input.disparity.packing), readers::packing_names(),
               kPackedHelp, {"--packed"}),
        flag(KEY(input.disparity.flip), kFlipHelp, {"--flip"}),
        choice("input.disparity.densify", MEMBER(input.densify), {"auto", "off"},
               "a supplied map of scattered measurements, as a laser's: auto = filled between them, by the "
               "picture's colours where there is one; other maps stay as they are; off = meshed as it is"),
        choice(KEY(input.depth.kind), {"depth", "inverse_depth", "affine_inverse", "affine_depth"},
               "what a supplied depth map's samples are; affine_inverse: depth = 1 / (affine_shift + "
               "affine_scale * sample), as networks give for single pictures; affine_depth: depth = "
               "affine_shift + affine_scale * sample, as Marigold and GeoWizard do",
               {"--depth-kind"}),
        text(KEY(input.depth.unit),
             "m, mm, or a number by which samples are divided to give metres (one over metres for "
             "inverse_depth); empty = mm for 16-bit integers, m for floats",
             {"--depth-unit", "U"}),
        flag(KEY(input.depth.ray),
             "distances are along the ray of each pixel instead of along the optical axis"),
        number(KEY(input.depth.near_m), "m", {0, kAny}, "what is nearer is unknown; 0 = no limit"),
        number(KEY(input.depth.far_m), "m", {0, kAny}, "what is farther is unknown; 0 = no limit"),
        optional(KEY(input.depth.affine_shift), "", {-kAny, kAny},
                 "for the affine kinds; null = 0, or where affine_scale is null as well, relative depths "
                 "whose farthest is ten times the nearest"),
        optional(KEY(input.depth.affine_scale), "", {-kAny, kAny},
                 "for the affine kinds; null = 1, or as said for affine_shift"),
        optional(KEY(input.depth.unknown), "", {-kAny, kAny},
                 "sample that means 'not known'; null = the format's own (0 in integer maps, but not for the "
                 "affine kinds; 65535 in 16-bit maps of depth); NaN, inf and depths of 0 or less always do",
                 {"--unknown", "V"}),
        text(KEY(input.depth.key), kKeyHelp, {"--key", "NAME"}),
        choice("input.depth.packed", MEMBER(input.depth.packing), readers::packing_names(), kPackedHelp,
               {"--packed"}),
        flag(KEY(input.depth.flip), kFlipHelp, {"--flip"}),
        flag(KEY(input.mask.inverted), "what is not 0 is unknown instead"),
        flag(KEY(input.mask.alpha), "what is transparent in the left picture (alpha below half) is unknown"),
        number(KEY(input.confidence.threshold), "", {-kAny, kAny},
               "what is below is unknown; integers are shares of 255 or 65535, or of 2 where none is above 2 "
               "(levels 0, 1, 2), floats are compared as they are"),
        text(KEY(input.confidence.key),
             "array of an NPZ, channel of an EXR that holds them; empty = the only one, or the usual names"),
        file(KEY(input.calibration.file),
             "the camera: Middlebury calib.txt, KITTI, OpenCV, a camera matrix, ROS, Kalibr, ZED, COLMAP and "
             "others (exporters/FORMATS.md), a second time for a second file; in a file relative to it; "
             "empty = none",
             {"--calib", "C", "input.calibration.second_file"}),
        file(KEY(input.calibration.second_file),
             "the right camera's file, where the first is the left one's, or extrinsics.yml with "
             "intrinsics.yml; empty = the file of that name beside the first (left, right; cam0, cam1), if "
             "it is needed"),
        optional(KEY(input.calibration.focal_px), "px", {1, 1e6}, "focal length; null = the file's"),
        optional(KEY(input.calibration.fov_x_deg), "deg", {1, 179},
                 "angle of view across the width, in place of a focal length; null = not given",
                 {"--fov-x", "DEG"}),
        optional(KEY(input.calibration.baseline_m), "m", {1e-6, 1e6},
                 "distance of the two cameras; null = the file's"),
        optional(KEY(input.calibration.cx), "px", {-1e6, 1e6},
                 "principal point from the image's left edge (the first pixel's centre is 0.5); null = the "
                 "file's or the middle"),
        optional(KEY(input.calibration.cy), "px", {-1e6, 1e6},
                 "principal point from the image's upper edge; null = the file's or the middle"),
        optional(KEY(input.calibration.doffs_px), "px", {-65536, 65536},
                 "added to a disparity before depth = focal * baseline / disparity; null = the file's or 0"),
        choice(KEY(input.calibration.rectify), {"auto", "always", "never"},
               "rectify the pair by the file's K1, D1, K2, D2, R and T; auto = unless the file has Q, or P1 "
               "and P2, as well and the pair's rows are the same already"),
        choice(KEY(input.stereo.layout), {"auto", "sbs", "sbs-half", "tb", "tb-half", "mpo"},
               "how --stereo's file holds both views: sbs = side by side, tb = top and bottom, half = each "
               "squeezed to half of that side; auto = by the file: spatial HEIC, two JPEG pictures as in "
               "MPO, .jps, or words of its name, such as sbs, left-right, over-under",
               {"--layout"}),
        flag(KEY(input.stereo.right_first), "the right view is on the left, or above, as for crossed eyes"),
    };
}

// The path and the member of a key of the section export.
#define EXPORT(key) "export." #key, MEMBER(exporting.key)

std::vector<Field> export_fields() {
    return {
        choice(EXPORT(compression), {"none", "draco", "quantized", "meshopt"},
               "of .glb and .gltf: KHR_draco_mesh_compression, KHR_mesh_quantization, "
               "EXT_meshopt_compression; .drc is always Draco"),
        number(EXPORT(tolerance_px), "px", {0.001, 100},
               "largest error of compressed positions, seen by the camera, in x, y and disparity, and of "
               "texture coordinates in the texture"),
        number(EXPORT(tolerance_share), "", {0, 100},
               "above 0, tolerance_px is lowered to this share of the surface's own error away from "
               "discontinuities (surface.flat_rmse_px); 0 = it is not"),
        number(EXPORT(tolerance_deg), "deg", {0.01, 30}, "largest error of compressed normals"),
        choice(EXPORT(material), {"emissive", "unlit", "lit"},
               "how .glb, .gltf and .usdz show the texture: unlit = as it is, by KHR_materials_unlit, which "
               "VTK 9.1 and f3d 1.3 show white; emissive = as light of its own, right there, but black in "
               "CesiumJS and too bright in model-viewer; lit = by the program's lights"),
        choice(EXPORT(normals), {"auto", "always", "never"},
               "auto = where lights fall on the mesh: not in .glb, .gltf and .usdz with a texture that is "
               "emissive or unlit; programs make their own where there are none"),
        flag(EXPORT(texcoords),
             "write texture coordinates; without them .glb, .gltf and .obj have no texture"),
        choice(EXPORT(texture), {"none", "jpeg", "png", "webp"},
               "image on the surface; jpeg may be the picture's own PNG, see texture_quality; "
               "webp is EXT_texture_webp in glTF; none also leaves a .ply's colours out"),
        number(
            EXPORT(texture_quality), "", {1, 100},
            "of a JPEG or WebP texture; what the picture's own JPEG, PNG or WebP file has is kept for up to "
            "4/3 of the bytes"),
        number(EXPORT(texture_max_px), "px", {0, 65500},
               "longest side of the texture, larger ones are scaled down; 0 = as large as it is"),
        flag(EXPORT(texture_crop), "crop the texture to what the mesh shows"),
        flag(EXPORT(camera),
             "the left camera in .glb and .gltf, so that viewers can start at the photograph"),
        choice(EXPORT(origin), {"auto", "camera", "base"},
               "where files have their origin: camera = the left camera; base = below the middle of the "
               "mesh, as low as its lowest point; auto = base in .usdz, which phones put onto the floor; "
               ".drc, .stl, .3mf and .html always have the camera's"),
        choice(EXPORT(provenance), {"cameras", "matches"},
               "what vertices tell in .glb, .gltf, .html and .ply: cameras = which cameras saw them, if the "
               "mesh has more than the left view's part; matches = also which of the left view's were "
               "filled, because nothing matched or was measured there"),
        text(EXPORT(copyright), "of the photograph or the mesh, for .glb and .gltf"),
        choice(EXPORT(stl_unit), {"m", "mm"},
               "what 1 means in an .stl, which cannot say it; slicers take it for mm"),
        choice(EXPORT(up), {"y", "z"},
               "axis that points up in .obj, .ply and an .stl without a body; z is for programs of CAD and "
               "maps; the other formats have one of their own"),
        flag(EXPORT(ply_texcoords),
             "texture coordinates s, t in .ply, t = 0 at the bottom, of the texture that an .obj has with "
             "export.texture_crop=false"),
        choice(EXPORT(solid), {"none", "base", "shell"},
               "contents of .stl, .3mf, .glb and .gltf: none = the surface; base = a closed body on a flat "
               "base, for printing; shell = one as thick everywhere; of the left view only, in mm where the "
               "format has them"),
        number(EXPORT(solid_size_mm), "mm", {10, 10000}, "longer side of that base"),
        number(EXPORT(lod), "", {1, 8},
               "levels of detail, each of twice the spacing of the one before; 1 = the mesh alone"),
        choice(EXPORT(lod_storage), {"files", "inside"},
               "coarser levels: files = NAME.lod1.glb and so on; inside = in one .glb or .gltf by MSFT_lod, "
               "which Blender and others do not know: they show all levels on top of each other"),
        optional(EXPORT(draco.position_bits), "bit", {1, exporters::DracoConfig::kMostBits},
                 "quantisation of positions; null = by tolerance_px"),
        optional(EXPORT(draco.normal_bits), "bit", {2, exporters::DracoConfig::kMostBits},
                 "quantisation of normals; null = by tolerance_deg"),
        optional(EXPORT(draco.texcoord_bits), "bit", {1, exporters::DracoConfig::kMostBits},
                 "quantisation of texture coordinates; null = by tolerance_px"),
        number(EXPORT(draco.level), "", {0, 10}, "0 = fast, 10 = small"),
    };
}

}  // namespace hexrelief::config
