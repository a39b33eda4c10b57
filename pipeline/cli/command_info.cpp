#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "exporters/exporter.h"
#include "exporters/inspect/limited.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/piped_inputs.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/data/error.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/input.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/cameras/exif_focal.h"
#include "pipeline/readers/cameras/stereo_calibration_reader.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/describe_map.h"
#include "pipeline/readers/describe_raster.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/photographs/contained_pictures.h"
#include "pipeline/readers/photographs/exif.h"
#include "pipeline/readers/photographs/stereo_reader.h"

namespace hexrelief::cli {
namespace {

namespace fs = std::filesystem;

struct RasterOptions {
    std::string key;
    std::optional<long long> max_pixels;
    bool json = false;

    readers::ReaderLimits limits() const {
        return {max_pixels.value_or(readers::kMaxPixels), "--max-pixels"};
    }
};

using Json = nlohmann::ordered_json;

// One thing that is told of a file: in words, and as JSON has it.
struct Line {
    std::string name, words;
    Json value;
    bool is_of_list = false;
};
using Text = std::vector<Line>;

void line(Text& text, const std::string& name, const std::string& words) {
    text.push_back({name, words, words});
}
void line(Text& text, const std::string& name, const std::string& words, Json value) {
    text.push_back({name, words, std::move(value)});
}
void count(Text& text, const std::string& name, std::size_t number) {
    line(text, name, std::to_string(number), number);
}

void lines(Text& text, const std::string& name, const std::vector<std::string>& values) {
    for (const std::string& value : values) text.push_back({name, value, value, true});
}

// Returns the lines in words, a list's name before its first value only, or as an object of JSON.
std::string told(const Text& text, bool json) {
    std::string words, above;
    Json object = Json::object();
    for (const auto& [name, value_words, value, is_of_list] : text) {
        std::string label = is_of_list && name == above ? "" : name, key = name;
        label.resize(std::max<std::size_t>(label.size(), 14), ' ');
        words += label + printable(value_words) + "\n";
        std::replace(key.begin(), key.end(), ' ', '_');
        if (is_of_list)
            object[key].push_back(value);
        else
            object[key] = value;
        above = name;
    }
    return json ? object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n" : words;
}

Json size_json(int width, int height) {
    return {{"width", width}, {"height", height}};
}

std::string number(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.6g", value);
    return digits;
}

void tell_mesh(const inspect::MeshDescription& mesh, Text& text) {
    line(text, "format", mesh.format + (mesh.compression == "none" ? "" : ", " + mesh.compression));
    count(text, "vertices", mesh.vertices);
    count(text, "triangles", mesh.triangles);
    std::string levels;
    Json coarser = Json::array();
    for (const inspect::LevelDescription& level : mesh.coarser) {
        levels += (levels.empty() ? "" : "; ") + std::to_string(level.vertices) + " vertices, " +
                  std::to_string(level.triangles) + " triangles";
        coarser.push_back({{"vertices", level.vertices}, {"triangles", level.triangles}});
    }
    if (!levels.empty()) line(text, "coarser", levels, coarser);
    line(text, "attributes",
         std::string("positions") + (mesh.normals ? ", normals" : "") +
             (mesh.texcoords ? ", texture coordinates" : "") + (mesh.colors ? ", colours" : ""));
    if (!mesh.geometry_bytes.empty()) {
        std::string parts;
        Json by_name;
        for (const auto& [name, bytes] : mesh.geometry_bytes) {
            parts += (parts.empty() ? "" : ", ") + name + " " + std::to_string(bytes);
            by_name[name] = bytes;
        }
        line(text, "bytes", parts, by_name);
    }
    if (mesh.texture_bytes > 0)
        line(text, "texture", std::to_string(mesh.texture_bytes) + " bytes", mesh.texture_bytes);
    if (mesh.has_bounds)
        line(text, "bounds",
             "[" + number(mesh.min.x) + ", " + number(mesh.min.y) + ", " + number(mesh.min.z) + "] .. [" +
                 number(mesh.max.x) + ", " + number(mesh.max.y) + ", " + number(mesh.max.z) + "]",
             {{mesh.min.x, mesh.min.y, mesh.min.z}, {mesh.max.x, mesh.max.y, mesh.max.z}});
    if (!mesh.generator.empty()) line(text, "generator", mesh.generator);
}

// Adds the stored samples of a map, and how a run would read them by default.
void tell_map(const fs::path& path, const RasterOptions& options, Text& text) {
    const readers::MapDescription map = readers::describe_map(path, options.key, options.limits());
    if (map.known_share > 0)
        line(text, "values", number(map.least) + " .. " + number(map.largest), {map.least, map.largest});
    line(text, "known", number(100 * map.known_share) + " %", map.known_share);
    lines(text, "as depth", map.as_depth);
    lines(text, "as disparity", map.as_disparity);
    if (map.may_be_mask && map.known_share > 0) line(text, "as mask", "keeps the known");
}

// Returns what a run without a calibration would do to the rows of a file's two views.
std::string alignment_of(const fs::path& path, const readers::ReaderLimits& limits) {
    try {
        job::RunLog log;
        const job::RunInput input =
            job::read_input(job::StereoFile{path}, {}, limits, job::effective_threads(0), log);
        const alignment::Alignment& found = *input.pair()->alignment;
        if (job::is_aligned(found))
            return job::alignment_text(found, input.calibration.focal_px, input.focal_from);
        if (!found.reason.empty()) return "none: " + found.reason;
        return "none: rows are off by " + number(found.estimate.before.median_px) + " px in the median of " +
               std::to_string(found.matches) + " points";
    } catch (const Error& error) {
        return std::string("refused: ") + error.what();
    }
}

// Adds how a file that holds both views is read by `run --stereo`.
void tell_views(const fs::path& path, const RasterOptions& options, Text& text) {
    const auto views = readers::describe_stereo_file(path, options.limits());
    if (!views) return;
    line(text, "as stereo",
         "two views of " + std::to_string(views->width) + " x " + std::to_string(views->height) +
             " px: " + views->told);
    const Calibration& camera = views->camera;
    if (camera.focal_px > 0)
        line(text, "camera",
             "focal " + number(camera.focal_px) + " px, baseline " +
                 (camera.baseline_m > 0 ? number(camera.baseline_m) + " m: a mesh in metres" : "not known") +
                 ", said by the file");
    line(text, "alignment", alignment_of(path, options.limits()));
}

// Adds a photograph's focal length, its orientation and its transparent pixels.
void tell_picture(const fs::path& path, const readers::FileDescription& raster, const RasterOptions& options,
                  Text& text) {
    const int orientation = readers::read_orientation(path);
    if (orientation != readers::kUpright)
        line(text, "orientation",
             readers::orientation_text(orientation) +
                 ", as its EXIF orientation says (input.exif_orientation); a map's picture only if it then "
                 "fits");
    if (const auto focal = readers::read_exif_focal(path, raster.width, raster.height))
        line(text, "focal", number(focal->focal_px) + " px by EXIF: " + focal->believed);
    for (const std::string& picture : readers::list_pictures(path, options.limits()))
        line(text, "holds", picture);
    tell_views(path, options, text);
    if (raster.format == "heic" || (raster.channels != 2 && raster.channels != 4)) return;
    const std::vector<std::uint8_t> alpha = readers::read_image(path, options.limits()).alpha;
    const auto transparent = std::ranges::count_if(alpha, [](std::uint8_t a) { return a < kOpaque; });
    if (transparent > 0)
        line(text, "alpha",
             number(100.0 * static_cast<double>(transparent) / static_cast<double>(alpha.size())) +
                 " % transparent, unknown unless input.mask.alpha is false");
}

// Adds the depths that a file holds beside a photograph.
void tell_auxiliary(const fs::path& path, const RasterOptions& options, Text& text) {
    try {
        lines(text, "as depth", readers::describe_map(path, {}, options.limits()).as_depth);
    } catch (const Error& error) {
        if (readers::describe_stereo_file(path, options.limits())) return;
        line(text, "as depth", error.what());
    }
}

void tell_calibration(const readers::CalibrationFile& file, Text& text) {
    const Calibration& camera = file.calibration;
    line(text, "format", "calibration, " + file.format);
    line(text, "focal", number(camera.focal_px) + " px", camera.focal_px);
    if (camera.baseline_m > 0)
        line(text, "baseline", number(camera.baseline_m) + " m", camera.baseline_m);
    else
        line(text, "baseline", "not known", nullptr);
    line(text, "centre",
         std::isnan(camera.cx) ? "not said: the middle"
                               : "(" + number(camera.cx) + ", " + number(camera.cy) +
                                     ") px, the first pixel's centre is (0.5, 0.5)",
         std::isnan(camera.cx) ? Json() : Json({camera.cx, camera.cy}));
    line(text, "doffs", number(camera.doffs_px) + " px", camera.doffs_px);
    if (camera.width > 0)
        line(text, "size", std::to_string(camera.width) + " x " + std::to_string(camera.height) + " px",
             size_json(camera.width, camera.height));
    if (file.depth_per_m > 0) line(text, "depths", number(file.depth_per_m) + " integers in a metre");
    if (!file.other.empty()) line(text, "also", file.other.string());
    for (const std::string& told : file.told) line(text, "note", told);
}

// Adds the calibration of two unrectified cameras.
void tell_stereo_calibration(const readers::StereoCalibrationFile& file, Text& text) {
    const StereoCalibration& cameras = file.calibration;
    line(text, "format",
         "calibration, " + file.format + ", of a pair to rectify" + (cameras.is_fisheye ? ", fisheye" : ""));
    for (const auto& [name, camera] : {std::pair{"left", cameras.left}, {"right", cameras.right}})
        line(text, name,
             "focal " + number(camera.matrix[0]) + " and " + number(camera.matrix[4]) + " px, " +
                 std::to_string(camera.distortion.size()) + " numbers of distortion");
    const auto& t = cameras.translation;
    const double baseline_m = std::hypot(t[0], t[1], t[2]);
    line(text, "baseline", number(baseline_m) + " m", baseline_m);
    if (cameras.width > 0)
        line(text, "size", std::to_string(cameras.width) + " x " + std::to_string(cameras.height) + " px",
             size_json(cameras.width, cameras.height));
    if (!file.other.empty()) line(text, "also", file.other.string());
    for (const std::string& told : file.told) line(text, "note", told);
}

void tell_calibration_of(const fs::path& path, Text& text) {
    const auto stereo = readers::read_stereo_calibration(path, readers::Rectify::automatic);
    if (stereo && !stereo->is_rectified)
        tell_stereo_calibration(*stereo, text);
    else
        tell_calibration(readers::read_calibration_file(path), text);
}

// Adds the calibration in a file of arrays; false if the file is no camera, but perhaps a map.
bool tell_if_calibration(const fs::path& path, Text& text) {
    try {
        tell_calibration_of(path, text);
    } catch (const Error&) {
        return false;
    }
    return true;
}

// True for a camera's matrix, of up to 4 x 4 numbers: no map is as small.
bool is_matrix(const readers::FileDescription& raster, unsigned gives) {
    constexpr int most = 4;
    return (gives & readers::codec::kCamera) != 0 && (gives & readers::codec::kPicture) == 0 &&
           raster.width <= most && raster.height <= most;
}

void tell_raster(const fs::path& path, const readers::FileDescription& raster, const RasterOptions& options,
                 Text& text) {
    const unsigned gives = readers::codec::find_codec(path)->gives;
    if (is_matrix(raster, gives) && tell_if_calibration(path, text)) return;
    line(text, "format", raster.format);
    line(text, "size", std::to_string(raster.width) + " x " + std::to_string(raster.height) + " px",
         size_json(raster.width, raster.height));
    line(text, "channels", std::to_string(raster.channels), raster.channels);
    line(text, "bits", std::to_string(raster.bits) + (raster.is_float ? " (float)" : ""), raster.bits);
    if (raster.format == "heic") {
        tell_picture(path, raster, options, text);
        tell_auxiliary(path, options, text);
        return;
    }
    const bool is_map = (gives & readers::codec::kMap) != 0;
    if (is_map && (raster.channels == 1 || raster.format == "exr"))
        tell_map(path, options, text);
    else if (!raster.is_float)
        tell_picture(path, raster, options, text);
}

// Describes a file that may hold several arrays or parts, of which none may be the usual one.
Text described(const fs::path& path, const RasterOptions& options) {
    Text text;
    const std::vector<std::string> contents = readers::list_contents(path, options.limits());
    lines(text, "holds", contents);
    try {
        if (const auto raster = readers::describe_raster(path, options.key, options.limits()))
            tell_raster(path, *raster, options, text);
    } catch (const Error& error) {
        if (contents.empty() || !options.key.empty()) throw;
        if (!tell_if_calibration(path, text)) line(text, "as map", error.what());
    }
    return text;
}

// Describes a picture or a map in a process of its own, because other libraries decode them. Files of
// pictures and maps decode at more than 256 KiB per second. A map takes 8 bytes per pixel here: 1 GiB is
// enough for 134 megapixels at any packing, and 64 bytes per byte of the file for maps that are packed
// less than 8 times.
std::string raster_text(const fs::path& path, const RasterOptions& options) {
    const std::uintmax_t bytes = fs::file_size(path);
    const inspect::WorkLimits limits{2 + static_cast<unsigned>(bytes >> 18),
                                     (std::uint64_t{1} << 30) + 64 * bytes, 1 << 20};
    const inspect::WorkBytes printed =
        inspect::run_limited(limits, "cannot read '" + path.string() + "': ", [&] {
            const std::string text = told(described(path, options), options.json);
            return inspect::WorkBytes(text.begin(), text.end());
        });
    return {printed.begin(), printed.end()};
}

std::string information(const fs::path& path, const RasterOptions& options) {
    std::error_code code;
    if (!fs::exists(path, code)) throw Error(ErrorKind::input, path.string() + ": no such file");
    if (fs::is_directory(path, code))
        throw Error(ErrorKind::input, path.string() + ": a folder; give a file");
    Text text;
    if (exporters::find_mesh_format(path)) {
        tell_mesh(exporters::describe_mesh(path), text);
        return told(text, options.json);
    }
    if (readers::codec::find_codec(path)) return raster_text(path, options);
    try {
        tell_calibration_of(path, text);
    } catch (const Error& e) {
        throw Error(
            e.kind(),
            std::string(e.what()) +
                " (neither a mesh's extension nor an image's first bytes, so taken for a calibration)");
    }
    return told(text, options.json);
}

}  // namespace

void add_info_command(Command& program) {
    Command command = program.add_command("info", "what a mesh, map, image or calibration file holds");
    const auto path = std::make_shared<fs::path>();
    const auto options = std::make_shared<RasterOptions>();
    command.add_option(
        "FILE", path.get(),
        "mesh (" + exporters::export_extensions() +
            "), image, map of disparity or depth, mask, or calibration; - = the standard input",
        {.required = true});
    command.add_option("--key", &options->key, "array of an NPZ, channel of an EXR", {.value = "NAME"});
    command.add_option(
        "--max-pixels", &options->max_pixels,
        "refuse images and maps of more, by their header; default " + std::to_string(readers::kMaxPixels),
        {.value = "N"});
    command.add_flag("--json", options->json, "as JSON");
    command.set_footer(
        "Examples:\n  hexrelief info relief.glb\n  hexrelief info disp0.pfm\n  hexrelief info depth.npz "
        "--key depth\n  hexrelief info calib.txt");
    command.set_action([path, options] {
        if (const long long most = options->limits().max_pixels; most < 1 || most > readers::kMaxPixels)
            throw Error(ErrorKind::usage,
                        "--max-pixels: must be from 1 to " + std::to_string(readers::kMaxPixels));
        PipedInputs pipes;
        try {
            std::fputs(information(pipes.file_of(path->string()), *options).c_str(), stdout);
        } catch (const Error& error) {
            throw Error(error.kind(), pipes.named(error.what()));
        }
        return 0;
    });
}

}  // namespace hexrelief::cli
