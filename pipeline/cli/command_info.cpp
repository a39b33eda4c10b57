#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "exporters/exporter.h"
#include "exporters/inspect/limited.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/piped_inputs.h"
#include "pipeline/cli/tell_calibration.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/disparities.h"
#include "pipeline/job/input.h"
#include "pipeline/readers/cameras/exif_focal.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/depth/describe_map.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/photographs/exif.h"
#include "pipeline/readers/photographs/stereo_reader.h"

namespace hexrelief::cli {
namespace {

namespace fs = std::filesystem;
using namespace info;

struct RasterOptions {
    std::string key;
    std::optional<long long> max_pixels;
    bool json = false;

    readers::ReaderLimits limits() const {
        return {max_pixels.value_or(readers::kMaxPixels), "--max-pixels"};
    }
};

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
    if (const auto seen = std::accumulate(mesh.provenance.begin(), mesh.provenance.end(), 0LL); seen > 0) {
        std::string shares;
        Json by_name;
        for (std::size_t k = 0; k < mesh.provenance.size(); ++k) {
            if (mesh.provenance[k] == 0 && k == static_cast<std::size_t>(Provenance::filled)) continue;
            const double percent =
                100.0 * static_cast<double>(mesh.provenance[k]) / static_cast<double>(seen);
            shares += (k == 0 ? "" : ", ") + std::string(kProvenanceNames[k]) + " " +
                      number(std::round(10 * percent) / 10) + " %";
            by_name[kProvenanceNames[k]] = mesh.provenance[k];
        }
        line(text, "seen by", shares + " of the vertices", by_name);
    }
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

// What a run without a calibration would do with a pair before it matches it.
struct PairForesight {
    std::vector<std::string> decisions, warnings;
    std::string refusal;  // why it would not; empty = it would
    // True if its points say that both pictures show one scene, from places that are nearer to each other
    // than to it: rows of windows match, too.
    bool is_one_scene = false;
};

PairForesight foresee(job::Source pair, const config::Config& config, const readers::ReaderLimits& limits) {
    PairForesight seen;
    job::RunLog log;
    log.decides = [&](const std::string& decision) { seen.decisions.push_back(decision); };
    try {
        const int threads = job::effective_threads(0);
        const job::RunInput input = job::foresee_input(std::move(pair), config.input, limits, threads, log);
        job::find_reduction(input, config.disparity, threads, log);
        const auto& found = input.pair()->alignment;
        seen.is_one_scene =
            found && found->verdict != alignment::Verdict::unclear &&
            (found->verdict != alignment::Verdict::aligned || input.calibration.baseline_m < 1);
    } catch (const Error& error) {
        seen.refusal = error.what();
    }
    seen.warnings = log.warnings();
    return seen;
}

void tell(const PairForesight& seen, Text& text) {
    lines(text, "a run", seen.decisions);
    lines(text, "it warns", seen.warnings);
    if (!seen.refusal.empty()) line(text, "it refuses", seen.refusal);
}

// Adds what a run would do with the halves of a wide picture, or of one whose name says that it has two, if
// they are two views of one scene.
void tell_halves(const fs::path& path, const readers::FileDescription& raster, const RasterOptions& options,
                 Text& text) {
    constexpr double kWide = 1.3;      // a stereo card's views are higher than wide
    constexpr int kPixelsOfByte = 32;  // more is no photograph, and would take long
    const bool is_named = readers::names_layout(path);
    if ((!is_named && raster.width < kWide * raster.height) ||
        static_cast<double>(raster.width) * raster.height >
            kPixelsOfByte * static_cast<double>(fs::file_size(path)))
        return;
    config::Config config;
    if (!is_named) config.input.stereo.layout = readers::StereoLayout::side_by_side;
    const PairForesight seen = foresee(job::StereoFile{path}, config, options.limits());
    if (!seen.refusal.empty() || !seen.is_one_scene) return;
    line(text, "as stereo",
         std::string(is_named ? "as its name says" : "with --layout sbs") + ": its halves show one scene");
    tell(seen, text);
}

// Adds how a file that holds both views is read by `run --stereo`.
void tell_views(const fs::path& path, const readers::FileDescription& raster, const RasterOptions& options,
                Text& text) {
    const auto views = readers::describe_stereo_file(path, options.limits());
    if (!views) {
        tell_halves(path, raster, options, text);
        return;
    }
    line(text, "as stereo",
         "two views of " + size_text(views->width, views->height, " x ") + " px: " + views->told);
    const Calibration& camera = views->camera;
    if (camera.focal_px > 0)
        line(text, "camera",
             "focal " + number(camera.focal_px) + " px, baseline " +
                 (camera.baseline_m > 0 ? number(camera.baseline_m) + " m: a mesh in metres" : "not known") +
                 ", said by the file");
    tell(foresee(job::StereoFile{path}, {}, options.limits()), text);
}

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
    tell_views(path, raster, options, text);
    if (raster.format == "heic" || (raster.channels != 2 && raster.channels != 4)) return;
    const std::vector<std::uint8_t> alpha = readers::read_image(path, options.limits()).alpha;
    const auto transparent = std::ranges::count_if(alpha, [](std::uint8_t a) { return a < kOpaque; });
    if (transparent > 0)
        line(text, "alpha",
             number(100.0 * static_cast<double>(transparent) / static_cast<double>(alpha.size())) +
                 " % transparent, unknown unless input.mask.alpha is false");
}

void tell_auxiliary(const fs::path& path, const RasterOptions& options, Text& text) {
    try {
        lines(text, "as depth", readers::describe_map(path, {}, options.limits()).as_depth);
    } catch (const Error& error) {
        if (readers::describe_stereo_file(path, options.limits())) return;
        line(text, "as depth", error.what());
    }
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
    size_line(text, raster.width, raster.height);
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

// Returns the text that `tell` makes of files of pictures or maps in a process of its own, because other
// libraries decode them. Such files decode at more than 256 KiB per second; four seconds are for a pair's
// points. A map takes 8 bytes per pixel here: 1 GiB is enough for 134 megapixels at any packing, and 64 bytes
// per byte of the files for maps that are packed less than 8 times.
std::string told_apart(const std::vector<fs::path>& paths, const RasterOptions& options,
                       const std::function<Text()>& tell) {
    std::uintmax_t bytes = 0;
    for (const fs::path& path : paths) bytes += fs::file_size(path);
    const inspect::WorkLimits limits{4 + static_cast<unsigned>(bytes >> 18),
                                     (std::uint64_t{1} << 30) + 64 * bytes, 1 << 20};
    const inspect::WorkBytes printed =
        inspect::run_limited(limits, "cannot read '" + paths[0].string() + "': ", [&] {
            const std::string text = told(tell(), options.json);
            return inspect::WorkBytes(text.begin(), text.end());
        });
    return {printed.begin(), printed.end()};
}

void check_file(const fs::path& path) {
    std::error_code code;
    if (!fs::exists(path, code)) throw Error(ErrorKind::input, path.string() + ": no such file");
    if (fs::is_directory(path, code))
        throw Error(ErrorKind::input, path.string() + ": a folder; give a file");
}

std::string information_of_pair(const fs::path& left, const fs::path& right, const RasterOptions& options) {
    for (const fs::path& path : {left, right}) {
        check_file(path);
        if (!readers::codec::find_codec(path))
            throw Error(ErrorKind::input, path.string() +
                                              ": no picture; two files are taken for the left "
                                              "and the right picture of a pair");
    }
    return told_apart({left, right}, options, [&] {
        Text text;
        for (const auto& [name, path] : {std::pair{"left", left}, {"right", right}})
            if (const auto raster = readers::describe_raster(path, {}, options.limits()))
                line(text, name,
                     raster->format + ", " + size_text(raster->width, raster->height, " x ") + " px");
        tell(foresee(job::PairFiles{left, right}, {}, options.limits()), text);
        return text;
    });
}

std::string information(const fs::path& path, const RasterOptions& options) {
    check_file(path);
    Text text;
    if (exporters::find_mesh_format(path)) {
        tell_mesh(exporters::describe_mesh(path), text);
        return told(text, options.json);
    }
    if (readers::codec::find_codec(path))
        return told_apart({path}, options, [&] { return described(path, options); });
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
    Command command = program.add_command(
        "info", "what a mesh, map, image or calibration file holds; what a run would do with a pair");
    const auto path = std::make_shared<fs::path>(), right = std::make_shared<fs::path>();
    const auto options = std::make_shared<RasterOptions>();
    command.add_option(
        "FILE", path.get(),
        "mesh (" + exporters::export_extensions() +
            "), image, map of disparity or depth, mask, or calibration; - = the standard input",
        {.required = true});
    command.add_option("RIGHT", right.get(),
                       "the right picture of a pair: tells what a run would do with both, or why it would "
                       "refuse them");
    command.add_option("--key", &options->key, "array of an NPZ, channel of an EXR", {.value = "NAME"});
    command.add_option(
        "--max-pixels", &options->max_pixels,
        "refuse images and maps of more, by their header; default " + std::to_string(readers::kMaxPixels),
        {.value = "N"});
    command.add_flag("--json", options->json, "as JSON");
    command.set_footer(R"(Examples:
  hexrelief info relief.glb
  hexrelief info disp0.pfm
  hexrelief info depth.npz --key depth
  hexrelief info calib.txt
  hexrelief info left.jpg right.jpg)");
    command.set_action([path, right, options] {
        if (const long long most = options->limits().max_pixels; most < 1 || most > readers::kMaxPixels)
            throw Error(ErrorKind::usage,
                        "--max-pixels: must be from 1 to " + std::to_string(readers::kMaxPixels));
        PipedInputs pipes;
        try {
            const fs::path file = pipes.file_of(path->string());
            const std::string text =
                right->empty() ? information(file, *options) : information_of_pair(file, *right, *options);
            std::fputs(text.c_str(), stdout);
        } catch (const Error& error) {
            throw Error(error.kind(), pipes.named(error.what()));
        }
        return 0;
    });
}

}  // namespace hexrelief::cli
