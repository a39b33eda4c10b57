#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "exporters/exporter.h"
#include "exporters/inspect/describe.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/cameras/exif_focal.h"
#include "pipeline/readers/cameras/stereo_calibration_reader.h"
#include "pipeline/readers/depth/describe_map.h"
#include "pipeline/readers/describe.h"
#include "pipeline/readers/image_reader.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

bool is_mesh_file(const fs::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const std::string& known : export_extensions())
        if (extension == known) return true;
    return false;
}

void line(const char* name, const std::string& value) {
    std::printf("%-14s%s\n", name, printable(value).c_str());
}

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

void print_mesh(const MeshDescription& mesh) {
    line("format", mesh.format + (mesh.compression == "none" ? "" : ", " + mesh.compression));
    line("vertices", std::to_string(mesh.vertices));
    line("triangles", std::to_string(mesh.triangles));
    std::string levels;
    for (const LevelDescription& level : mesh.coarser)
        levels += (levels.empty() ? "" : "; ") + std::to_string(level.vertices) + " vertices, " +
                  std::to_string(level.triangles) + " triangles";
    if (!levels.empty()) line("coarser", levels);
    line("attributes", std::string("positions") + (mesh.normals ? ", normals" : "") +
                           (mesh.texcoords ? ", texture coordinates" : "") +
                           (mesh.colors ? ", colours" : ""));
    if (!mesh.geometry_bytes.empty()) {
        std::string parts;
        for (const auto& [name, bytes] : mesh.geometry_bytes)
            parts += (parts.empty() ? "" : ", ") + name + " " + std::to_string(bytes);
        line("bytes", parts);
    }
    if (mesh.texture_bytes > 0) line("texture", std::to_string(mesh.texture_bytes) + " bytes");
    if (mesh.has_bounds)
        line("bounds", "[" + number(mesh.min.x) + ", " + number(mesh.min.y) + ", " + number(mesh.min.z) +
                           "] .. [" + number(mesh.max.x) + ", " + number(mesh.max.y) + ", " +
                           number(mesh.max.z) + "]");
    if (!mesh.generator.empty()) line("generator", mesh.generator);
}

// Samples as stored, and what a run would take them for without further words.
void print_map(const fs::path& path, const std::string& key) {
    const MapDescription map = describe_map(path, key);
    if (map.known_share > 0) line("values", number(map.least) + " .. " + number(map.largest));
    line("known", number(100 * map.known_share) + " %");
    line("as depth", map.as_depth);
    line("as disparity", map.as_disparity);
    if (map.may_be_mask && map.known_share > 0) line("as mask", "keeps the known");
}

// What a photograph tells of its lens and its transparent pixels.
void print_picture(const fs::path& path, const FileDescription& raster) {
    if (const auto focal = read_exif_focal(path, raster.width, raster.height))
        line("focal", number(focal->focal_px) + " px by EXIF: " + focal->believed);
    if (raster.channels != 2 && raster.channels != 4) return;
    const std::vector<std::uint8_t> alpha = read_image(path).alpha;
    const auto transparent = std::ranges::count_if(alpha, [](std::uint8_t a) { return a < kOpaque; });
    if (transparent > 0)
        line("alpha", number(100.0 * static_cast<double>(transparent) / static_cast<double>(alpha.size())) +
                          " % transparent, unknown unless input.mask.alpha is false");
}

// The depths beside a photograph.
void print_auxiliary(const fs::path& path) {
    try {
        line("as depth", describe_map(path, {}).as_depth);
    } catch (const Error& error) {
        line("as depth", error.what());
    }
}

void print_raster(const fs::path& path, const FileDescription& raster, const std::string& key) {
    line("format", raster.format);
    line("size", std::to_string(raster.width) + " x " + std::to_string(raster.height) + " px");
    line("channels", std::to_string(raster.channels));
    line("bits", std::to_string(raster.bits) + (raster.is_float ? " (float)" : ""));
    if (raster.format == "heic") {
        print_auxiliary(path);
        return;
    }
    const bool is_lossy = raster.format == "jpeg" || raster.format == "webp";
    if ((raster.channels == 1 && !is_lossy) || raster.format == "exr")
        print_map(path, key);
    else if (!raster.is_float)
        print_picture(path, raster);
}

void print_calibration(const CalibrationFile& file) {
    const Calibration& camera = file.calibration;
    line("format", "calibration, " + file.format);
    line("focal", number(camera.focal_px) + " px");
    line("baseline", camera.baseline_m > 0 ? number(camera.baseline_m) + " m" : "not known");
    line("centre", std::isnan(camera.cx) ? "not said: the middle"
                                         : "(" + number(camera.cx) + ", " + number(camera.cy) +
                                               ") px, the first pixel's centre is (0.5, 0.5)");
    line("doffs", number(camera.doffs_px) + " px");
    if (camera.width > 0)
        line("size", std::to_string(camera.width) + " x " + std::to_string(camera.height) + " px");
    for (const std::string& told : file.told) line("note", told);
}

// What a file says of two cameras as they stand.
void print_stereo_calibration(const StereoCalibrationFile& file) {
    const StereoCalibration& cameras = file.calibration;
    line("format",
         std::string("calibration, OpenCV, of a pair to rectify") + (cameras.is_fisheye ? ", fisheye" : ""));
    for (const auto& [name, camera] : {std::pair{"left", cameras.left}, {"right", cameras.right}})
        line(name, "focal " + number(camera.matrix[0]) + " and " + number(camera.matrix[4]) + " px, " +
                       std::to_string(camera.distortion.size()) + " numbers of distortion");
    const auto& t = cameras.translation;
    line("baseline", number(std::hypot(t[0], t[1], t[2])) + " m");
    if (cameras.width > 0)
        line("size", std::to_string(cameras.width) + " x " + std::to_string(cameras.height) + " px");
    for (const std::string& told : file.told) line("note", told);
}

void print_calibration_of(const fs::path& path) {
    if (const auto stereo = read_stereo_calibration(path, Rectify::automatic))
        print_stereo_calibration(*stereo);
    else
        print_calibration(read_calibration_file(path));
}

int inform(const fs::path& path, const std::string& key) {
    std::error_code code;
    if (!fs::exists(path, code)) throw Error(ErrorKind::input, path.string() + ": no such file");
    if (fs::is_directory(path, code))
        throw Error(ErrorKind::input, path.string() + ": a folder; give a file");
    if (is_mesh_file(path)) {
        print_mesh(describe_mesh(path));
        return 0;
    }
    if (const auto raster = describe_raster(path, key)) {
        print_raster(path, *raster, key);
        return 0;
    }
    try {
        print_calibration_of(path);
    } catch (const Error& e) {
        throw Error(
            e.kind(),
            std::string(e.what()) +
                " (neither a mesh's extension nor an image's first bytes, so taken for a calibration)");
    }
    return 0;
}

}  // namespace

void add_info_command(Command& program) {
    Command command = program.add_command("info", "what a mesh, map, image or calibration file holds");
    const auto path = std::make_shared<fs::path>();
    const auto key = std::make_shared<std::string>();
    command.add_option(
        "FILE", path.get(),
        "mesh (.glb .gltf .drc .obj .ply .stl .usdz .html), image, map of disparity or depth, mask, or "
        "calibration",
        {.required = true});
    command.add_option("--key", key.get(), "array of an NPZ, channel of an EXR", {.value = "NAME"});
    command.set_footer(
        "Examples:\n  hexrelief info relief.glb\n  hexrelief info disp0.pfm\n  hexrelief info depth.npz "
        "--key depth\n  hexrelief info calib.txt");
    command.set_action([path, key] { return inform(*path, *key); });
}

}  // namespace hexrelief
