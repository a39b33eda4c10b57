#include "pipeline/job/input.h"

#include <algorithm>
#include <future>
#include <utility>

#include "exporters/images/resize.h"
#include "pipeline/data/background.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "pipeline/files/sha256.h"
#include "pipeline/files/unchanged_files.h"
#include "pipeline/job/maps/depth_input.h"
#include "pipeline/job/maps/mask_input.h"
#include "pipeline/job/resolve_calibration.h"
#include "pipeline/job/run_files.h"
#include "pipeline/readers/cameras/stereo_calibration_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/stereo_reader.h"
#include "pipeline/rectify/rectify.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

template <typename Raster>
ViewSize size_of(const Raster& raster) {
    return {raster.width, raster.height};
}

InputFile hashed(const std::string& role, const fs::path& path) {
    return {role, path.string(), files::sha256_of_file(path)};
}

struct HashedImage {
    Image image;
    InputFile file;
};

HashedImage read_hashed(const std::string& role, const fs::path& path, const RunRequest& request) {
    return {readers::read_image(path, request.config.limits.reading), hashed(role, path)};
}

RunInput read_stereo(const RunRequest& request, const RunLog& log) {
    RunInput input;
    input.pair =
        readers::read_stereo_file(request.stereo, request.config.input.stereo, request.config.limits.reading);
    input.files.push_back(hashed("stereo", request.stereo));
    log.decide("stereo: two views of " + size_text(size_of(input.pair.left)) + " px");
    return input;
}

RunInput read_pair(const RunRequest& request, int threads) {
    RunInput input;
    auto reading_right = start_work(threads, [&] { return read_hashed("right", request.right, request); });
    HashedImage left_file = read_hashed("left", request.left, request), right_file = reading_right.get();
    const Image &left = input.pair.left = std::move(left_file.image),
                &right = input.pair.right = std::move(right_file.image);
    if (left.width != right.width || left.height != right.height)
        throw Error(ErrorKind::input, "the pair's sizes differ: " + request.left.string() + " has " +
                                          size_text(size_of(left)) + " px, " + request.right.string() + " " +
                                          size_text(size_of(right)) + "; rectified images have one size");
    input.files = {std::move(left_file.file), std::move(right_file.file)};
    return input;
}

// The picture of a map's view, which may have another size: then it is scaled to the map's for the stages,
// and kept as it is for the texture.
void take_picture(Image image, const fs::path& path, const fs::path& map_path, RunInput& input) {
    const ViewSize size = size_of(image), view = size_of(input.map);
    if (!same_aspect(size, view))
        throw Error(ErrorKind::input, path.string() + ": the colour image has " + size_text(size) +
                                          " px, but the map " + map_path.string() + " has " +
                                          size_text(view) +
                                          "; both must show the left view, with the same aspect");
    if (size == view) {
        input.pair.left = std::move(image);
        return;
    }
    input.pair.left = exporters::resized(image, view.width, view.height);
    input.picture = std::move(image);
}

// A depth map goes into `depth`, its size into the map: its disparities need the camera.
RunInput read_map(const RunRequest& request, int threads, readers::DepthFile& depth) {
    RunInput input;
    std::future<HashedImage> reading_color;
    if (!request.color.empty())
        reading_color = start_work(threads, [&] { return read_hashed("color", request.color, request); });
    const bool is_depth = !request.depth.empty();
    const fs::path& path = is_depth ? request.depth : request.disparity;
    if (is_depth) {
        depth = readers::read_depth_map(path, request.config.input.depth, request.config.limits.reading);
        input.map.width = depth.map.width;
        input.map.height = depth.map.height;
    } else {
        input.map =
            readers::read_disparity_map(path, request.config.input.disparity, request.config.limits.reading);
    }
    input.files.push_back(hashed(is_depth ? "depth" : "disparity", path));
    if (request.color.empty()) return input;
    HashedImage color_file = reading_color.get();
    take_picture(std::move(color_file.image), request.color, path, input);
    input.files.push_back(std::move(color_file.file));
    return input;
}

// At the view's size.
readers::PixelMask fitted(const readers::PixelMask& mask, ViewSize view, const fs::path& path) {
    const ViewSize size{mask.width, mask.height};
    if (size == view) return mask;
    if (!same_aspect(size, view))
        throw Error(ErrorKind::input, path.string() + ": it has " + size_text(size) + " px, but the view " +
                                          size_text(view) +
                                          "; both must show the left view, with the same aspect");
    return readers::resampled(mask, view.width, view.height);
}

// Of the pixels that have this value.
std::string percent_text(const readers::PixelMask& mask, std::uint8_t value) {
    return fixed(100.0 * static_cast<double>(std::ranges::count(mask.kept, value)) /
                     static_cast<double>(mask.kept.size()),
                 1);
}

// Of what is in memory; empty = none, or a file's.
struct GivenMasks {
    readers::PixelMask mask, confidence;
};

// For messages.
fs::path name_of(const fs::path& file, const char* in_memory) {
    return file.empty() ? fs::path(in_memory) : file;
}

// What the mask keeps goes into the input, and with what the confidences keep it is given back; empty = all.
// What a rectified view does not show is hidden likewise. Between the measurements that are sure a sparse map
// is filled, but not where a mask says that nothing is.
readers::PixelMask read_masks(const RunRequest& request, GivenMasks given, ViewSize view, RunInput& input,
                              RunLog& log) {
    const config::InputConfig& config = request.config.input;
    if (config.mask.alpha) {
        // take_picture() has found that it fits.
        if (const readers::PixelMask opaque = opaque_part(input.texture()); !opaque.empty()) {
            input.mask = both(std::move(input.mask), readers::resampled(opaque, view.width, view.height));
            log.decide("alpha: " + percent_text(opaque, 0) + " % of the picture is transparent, and unknown");
        }
    }
    if (!request.mask.empty())
        given.mask = readers::read_mask(request.mask, config.mask, request.config.limits.reading);
    if (!given.mask.empty())
        input.mask = both(std::move(input.mask), fitted(given.mask, view, name_of(request.mask, "mask")));
    if (!request.mask.empty()) input.files.push_back(hashed("mask", request.mask));
    readers::PixelMask kept = input.mask;
    if (!request.confidence.empty())
        given.confidence =
            readers::read_confidence(request.confidence, config.confidence, request.config.limits.reading);
    if (!given.confidence.empty())
        kept =
            both(std::move(kept), fitted(given.confidence, view, name_of(request.confidence, "confidence")));
    if (!request.confidence.empty()) input.files.push_back(hashed("confidence", request.confidence));
    if (!kept.empty()) log.decide("mask: keeps " + percent_text(kept, 1) + " % of the picture");
    return kept;
}

// Of the camera a depth map needs the focal length alone.
void take_depth_map(readers::DepthFile depth, const ResolvedCalibration& resolved,
                    const readers::DepthFileConfig& config, RunInput& input, RunLog& log) {
    Calibration& camera = input.calibration;
    if (!resolved.is_baseline_known) camera.baseline_m = 0;
    if (!resolved.is_focal_known)
        log.warn(
            "the focal length is not known and taken to be the picture's width, so depths may be stretched; "
            "give --calib FILE, --fov-x DEG or input.calibration.focal_px");
    input.believed.depth = depth.believed + (config.ray ? ", along the ray" : "");
    DepthInput taken = take_depths(std::move(depth), config, resolved.is_focal_known, camera);
    input.map = std::move(taken.map);
    if (taken.is_baseline_chosen) input.believed.baseline_from = "the nearest distance";
    for (const std::string& decision : taken.decisions) log.decide(decision);
}

// The file whose EXIF data tell of the left view's lens. Of two views in one picture they tell less.
fs::path photograph_of(const RunRequest& request) {
    if (request.stereo.empty()) return request.left.empty() ? request.color : request.left;
    const readers::StereoLayout layout = request.config.input.stereo.layout;
    const bool mpo = layout == readers::StereoLayout::automatic || layout == readers::StereoLayout::mpo;
    return mpo ? request.stereo : fs::path();
}

// In the pair's stead, where its calibration tells of the cameras as they stand.
void rectify_input(const RunRequest& request, int threads, RunInput& input, RunLog& log) {
    const config::CalibrationConfig& config = request.config.input.calibration;
    if (config.file.empty()) {
        if (config.rectify == readers::Rectify::always)
            throw Error(ErrorKind::usage, "input.calibration.rectify needs a calibration file (--calib)");
        return;
    }
    const auto file = readers::read_stereo_calibration(config.file, config.rectify);
    if (!file) return;
    const StereoCalibration& cameras = file->calibration;
    const ViewSize size = size_of(input.pair.left), made_for{cameras.width, cameras.height};
    if (made_for.width > 0 && made_for != size)
        throw Error(ErrorKind::input, config.file + ": the calibration is for " + size_text(made_for) +
                                          " px, but the pictures have " + size_text(size) +
                                          " px; use the calibration of that size");
    for (const std::string& told : file->told) log.warn(config.file + ": " + told);
    if (!request.stages_folder.empty())
        for (const fs::path& name : rectified_file_names())
            files::check_overwrites({request.stages_folder / name}, read_files(request));
    rectify::RectifiedPair rectified = rectify::rectify(input.pair, cameras, threads);
    if (const Image alpha{size.width, size.height, 1, input.pair.left.alpha}; !alpha.empty())
        rectified.pair.left.alpha = rectify::rectify({alpha, alpha}, cameras, threads).pair.left.pixels;
    input.pair = std::move(rectified.pair);
    input.calibration = rectified.calibration;
    input.is_rectified = true;
    if (std::count(rectified.seen.begin(), rectified.seen.end(), 0) > 0)
        input.mask = {size.width, size.height, std::move(rectified.seen)};
    log.decide(std::string("rectified: by ") +
               (cameras.is_fisheye ? "a fisheye model" : "K1, D1, K2, D2, R, T") + " of " + config.file);
}

// The camera, which is returned, the masks and what depends on them: the same for files and for what is in
// memory.
ResolvedCalibration complete_input(const RunRequest& request, readers::DepthFile depth, GivenMasks masks,
                                   RunInput& input, RunLog& log) {
    const bool is_depth = !depth.map.values.empty();
    const config::CalibrationConfig& config = request.config.input.calibration;
    const ViewSize view = input.is_pair() ? size_of(input.pair.left) : size_of(input.map);
    const Calibration rectified = input.calibration;
    const Image& picture = input.texture();
    const ResolvedCalibration resolved =
        resolve_calibration({config, view, picture.empty() ? view : size_of(picture),
                             input.is_rectified ? &rectified : nullptr, photograph_of(request)});
    if (!input.picture.empty())
        log.decide("picture: " + size_text(size_of(picture)) + " px, scaled to the map's " + size_text(view) +
                   " px; the texture keeps its size");
    const Calibration& camera = input.calibration = resolved.calibration;
    input.believed.focal_from = resolved.focal_from;
    input.believed.baseline_from = resolved.baseline_from;
    if (!config.file.empty()) input.files.push_back(hashed("calibration", config.file));
    for (const std::string& warning : resolved.warnings) log.warn(warning);
    for (const std::string& decision : resolved.decisions) log.decide(decision);
    readers::PixelMask kept = read_masks(request, std::move(masks), view, input, log);
    if (input.is_pair())
        input.mask = std::move(kept);
    else
        hide(is_depth ? depth.map.values : input.map.values, kept);
    if (is_depth) take_depth_map(std::move(depth), resolved, request.config.input.depth, input, log);
    log.decide("calibration: focal " + fixed(camera.focal_px, 2) + " px, baseline " +
               fixed(camera.baseline_m, 4) + (camera.metric ? " m" : " (relative)") + ", principal point (" +
               fixed(camera.cx, 2) + ", " + fixed(camera.cy, 2) + "), doffs " + fixed(camera.doffs_px, 2) +
               " px; focal by " + input.believed.focal_from + ", baseline by " +
               input.believed.baseline_from);
    return resolved;
}

// Of the mesh that will be made. One of depths is in metres by itself.
void warn_of_scale(const RunRequest& request, const ResolvedCalibration& resolved, RunLog& log) {
    if (!request.depth.empty()) return;
    if (const std::string missing = missing_for_metres(resolved); !missing.empty()) log.warn(missing);
}

}  // namespace

const std::vector<fs::path>& rectified_file_names() {
    static const std::vector<fs::path> names = {"left_rectified.png", "right_rectified.png", "calib.txt"};
    return names;
}

RunInput read_input(const RunRequest& request, int threads, RunLog& log) {
    const files::UnchangedFiles sources(read_files(request));
    const bool is_map = !request.depth.empty() || !request.disparity.empty();
    readers::DepthFile depth;
    RunInput input = !request.stereo.empty() ? read_stereo(request, log)
                     : is_map                ? read_map(request, threads, depth)
                                             : read_pair(request, threads);
    if (input.is_pair()) rectify_input(request, threads, input, log);
    warn_of_scale(request, complete_input(request, std::move(depth), {}, input, log), log);
    sources.check();
    return input;
}

RunInput take_pair(StereoPair pair, const RunRequest& request, RunLog& log) {
    if (pair.left.width != pair.right.width || pair.left.height != pair.right.height)
        throw Error(ErrorKind::input, "the pair's sizes differ: left has " + size_text(size_of(pair.left)) +
                                          " px, right " + size_text(size_of(pair.right)) +
                                          "; rectified images have one size");
    RunInput input;
    input.pair = std::move(pair);
    complete_input(request, {}, {}, input, log);
    return input;
}

RunInput take_map(MapArrays arrays, const RunRequest& request, RunLog& log) {
    RunInput input;
    const bool is_depth = !arrays.depth.map.values.empty();
    input.map = std::move(arrays.disparity);
    if (is_depth) {
        input.map.width = arrays.depth.map.width;
        input.map.height = arrays.depth.map.height;
    }
    if (!arrays.color.empty())
        take_picture(std::move(arrays.color), "color", is_depth ? "depth" : "disparity", input);
    warn_of_scale(request,
                  complete_input(request, std::move(arrays.depth),
                                 {std::move(arrays.mask), std::move(arrays.confidence)}, input, log),
                  log);
    return input;
}

}  // namespace hexrelief::job
