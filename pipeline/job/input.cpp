#include "pipeline/job/input.h"

#include <algorithm>
#include <future>
#include <iterator>
#include <utility>

#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/files/sha256.h"
#include "pipeline/job/maps/disparity_input.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/pairs/dark_strips.h"
#include "pipeline/job/pairs/working_size.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/photographs/exif.h"
#include "pipeline/readers/photographs/stereo_reader.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

template <typename Raster>
ViewSize size_of(const Raster& raster) {
    if constexpr (requires { raster.map; })
        return size_of(raster.map);
    else
        return {raster.width, raster.height};
}

struct HashedImage : readers::OrientedPicture {
    InputFile file;
};

InputFile hashed(const std::string& role, const fs::path& path) {
    return {role, path.string(), files::sha256_of_file(path)};
}

class InputReader {
  public:
    InputReader(const config::InputConfig& config, const readers::ReaderLimits& limits, int threads,
                RunLog& log, bool foresees)
        : config_(config), limits_(limits), threads_(threads), log_(log), foresees_(foresees) {}

    RunInput read(const PairFiles& source) {
        auto reading_right = start_work(threads_, [&] { return read_hashed("right", source.right); });
        HashedImage left = read_hashed("left", source.left), right = reading_right.get();
        tell(turn_upright(left, right, !config_.calibration.file.empty()));
        StereoPair views{std::move(left.image), std::move(right.image)};
        const std::string differ = sizes_differ(views, source.left.string(), source.right.string());
        const bool may_be_cut = config_.calibration.file.empty() && has_to_be_looked_at(config_);
        if (!differ.empty() && (!may_be_cut || !source.mask.empty()))
            throw Error(ErrorKind::input, differ + (may_be_cut ? ", as a mask needs" : ""));
        RunInput input{InputPair{std::move(views)}};
        input.files = {std::move(left.file), std::move(right.file)};
        return complete_pair(std::move(input), source.mask, source.left, false,
                             source.left.string() + " and " + source.right.string(), differ);
    }

    RunInput read(const StereoFile& source) {
        readers::StereoViews read =
            readers::read_stereo_file(source.file, config_.stereo, limits_, config_.exif_orientation);
        RunInput input{InputPair{std::move(read.views)}};
        input.files.push_back(hashed("stereo", source.file));
        log_.decide("stereo: two views of " + size_text(size_of(input.color())) + " px: " + read.told);
        if (read.camera.focal_px > 0) container_ = read.camera;
        // The EXIF data of one picture that joins two views describe neither lens well.
        const readers::StereoLayout layout = config_.stereo.layout;
        const bool mpo = layout == readers::StereoLayout::automatic || layout == readers::StereoLayout::mpo;
        return complete_pair(std::move(input), source.mask, mpo ? source.file : fs::path(), true,
                             source.file.string());
    }

    RunInput read(const DisparityFiles& source) { return read_map(source, "disparity"); }
    RunInput read(const DepthFiles& source) { return read_map(source, "depth"); }

    RunInput read(PairArrays& source) {
        const ViewSize size = size_of(source.views.left);
        if (const std::string differ = sizes_differ(source.views, "left", "right"); !differ.empty())
            throw Error(ErrorKind::input, differ);
        RunInput input{InputPair{std::move(source.views)}};
        find_camera(input, size, {});
        hide_strips(input);
        read_mask(input, size, {});
        tell_mask(input.mask);
        tell_camera(input);
        return input;
    }

    RunInput read(DisparityArrays& source) { return take_map(source, "disparity"); }
    RunInput read(DepthArrays& source) { return take_map(source, "depth"); }

  private:
    HashedImage read_hashed(const std::string& role, const fs::path& path) const {
        return {{readers::read_image(path, limits_), path,
                 config_.exif_orientation ? readers::read_orientation(path) : readers::kUpright},
                hashed(role, path)};
    }
    template <typename Step>
    void tell(const Step& done) {
        for (const std::string& warning : done.warnings) log_.warn(warning);
        for (const std::string& decision : done.decisions) log_.decide(decision);
    }
    readers::DisparityFile values_of(const DisparityFiles& source) const {
        return readers::read_disparity_file(source.map, before_doffs(config_.disparity), limits_);
    }
    readers::DepthFile values_of(const DepthFiles& source) const {
        return readers::read_depth_map(source.map, config_.depth, limits_, said_per_m(config_, source.map));
    }

    static void take_picture(Image image, const fs::path& path, ViewSize view, const fs::path& map_path,
                             RunInput& input) {
        InputMap& map = std::get<InputMap>(input.views);
        ViewPicture picture = picture_of_view(std::move(image), path, view, map_path);
        map.color = std::move(picture.color);
        map.picture = std::move(picture.picture);
    }
    template <typename MapFile>
    void fit(MapFile& file, ViewSize picture) {
        if (const auto done = fit_to_picture(file.map, picture.width, picture.height); !done.empty())
            log_.warn(done);
    }

    // Reads a map and the picture of its view. roles: of the two files.
    template <typename Files>
    auto read_view(const Files& source, const std::pair<const char*, const char*>& roles, RunInput& input) {
        std::future<HashedImage> reading_color;
        if (!source.color.empty())
            reading_color = start_work(threads_, [&] { return read_hashed(roles.second, source.color); });
        auto values = values_of(source);
        input.files.push_back(hashed(roles.first, source.map));
        if (reading_color.valid()) {
            HashedImage color = reading_color.get();
            tell(turn_to_fit(color, size_of(values).width, size_of(values).height));
            fit(values, size_of(color.image));
            take_picture(std::move(color.image), source.color, size_of(values), source.map, input);
            input.files.push_back(std::move(color.file));
        }
        return values;
    }

    void read_right(const DisparityFiles& source, RunInput& input) {
        InputMap& map = std::get<InputMap>(input.views);
        if (source.right.empty()) {
            if (source.color_right.empty()) return;
            HashedImage picture = read_hashed("color right", source.color_right);
            tell(turn_to_fit(picture, map.disparities.width, map.disparities.height));
            map.right_color = picture_of_view(std::move(picture.image), source.color_right,
                                              size_of(map.disparities), source.map)
                                  .color;
            input.files.push_back(std::move(picture.file));
            return;
        }
        RunInput right{InputMap{}};
        map.right = read_view(DisparityFiles{source.right, source.color_right},
                              {"disparity right", "color right"}, right)
                        .map;
        if (const ViewSize size = size_of(map.right), other = size_of(map.disparities); size != other)
            throw Error(ErrorKind::input, source.right.string() + ": it has " + size_text(size) +
                                              " px, but " + source.map.string() + " " + size_text(other) +
                                              "; both views' maps have one size");
        InputMap& view = std::get<InputMap>(right.views);
        map.right_color = std::move(view.color);
        map.right_picture = std::move(view.picture);
        std::ranges::move(right.files, std::back_inserter(input.files));
    }
    void read_right(const DepthFiles&, RunInput&) {}

    template <typename Files>
    RunInput read_map(const Files& source, const char* role) {
        RunInput input{InputMap{}};
        auto values = read_view(source, {role, "color"}, input);
        input = complete_map(std::move(input), std::move(values), source.color, {source.mask},
                             {source.confidence});
        read_right(source, input);
        return input;
    }

    template <typename Arrays>
    RunInput take_map(Arrays& source, const char* role) {
        RunInput input{InputMap{}};
        if (!source.color.empty()) {
            fit(source.map, size_of(source.color));
            take_picture(std::move(source.color), "color", size_of(source.map), role, input);
        }
        return complete_map(std::move(input), std::move(source.map), {}, {{}, std::move(source.mask)},
                            {{}, std::move(source.confidence)});
    }

    RunInput complete_pair(RunInput input, const fs::path& mask, const fs::path& photograph, bool is_rig,
                           const std::string& name, const std::string& differ = {}) {
        rectify_pair(input);
        const ResolvedCalibration camera = find_camera(input, size_of(input.color()), photograph);
        if (has_to_be_looked_at(config_))
            align(input, camera, {config_, name, is_rig, !mask.empty(), foresees_, differ});
        // The line that tells the alignment names the focal length's source and the units.
        if (!input.is_aligned()) warn_of_focal(camera);
        hide_strips(input);
        read_mask(input, size_of(input.color()), {mask});
        tell_mask(input.mask);
        tell_camera(input);
        if (!input.is_aligned()) warn_of_scale(camera);
        return input;
    }

    RunInput complete_map(RunInput input, readers::DisparityFile file, const fs::path& photograph,
                          MaskSource mask, MaskSource confidence) {
        const ResolvedCalibration camera = find_camera(input, size_of(file), photograph);
        warn_of_focal(camera);
        for (const std::string& warning : keep_in_front(file, camera.calibration.doffs_px))
            log_.warn(warning);
        hide(file.map.values, read_masks(input, size_of(file), std::move(mask), std::move(confidence)));
        InputMap& map = std::get<InputMap>(input.views);
        map.disparities = std::move(file.map);
        map.read_as = std::move(file.believed);
        if (!map.read_as.empty()) log_.decide("disparity: " + map.read_as);
        tell_camera(input);
        warn_of_scale(camera);
        return input;
    }

    // Does not warn of a missing scale: depths give the mesh its scale without a baseline.
    RunInput complete_map(RunInput input, readers::DepthFile depth, const fs::path& photograph,
                          MaskSource mask, MaskSource confidence) {
        const ResolvedCalibration camera = find_camera(input, size_of(depth), photograph);
        warn_of_focal(camera);
        hide(depth.map.values, read_masks(input, size_of(depth), std::move(mask), std::move(confidence)));
        take_depths_of(std::move(depth), camera, input);
        tell_camera(input);
        return input;
    }

    void rectify_pair(RunInput& input);
    void hide_strips(RunInput& input);
    void align(RunInput& input, const ResolvedCalibration& camera, const PairToAlign& given);
    ResolvedCalibration find_camera(RunInput& input, ViewSize view, const fs::path& photograph);
    void read_mask(RunInput& input, ViewSize view, MaskSource mask);
    // Returns the input's mask, read here, where the confidence suffices.
    readers::PixelMask read_masks(RunInput& input, ViewSize view, MaskSource mask, MaskSource confidence);
    void tell_mask(const readers::PixelMask& kept) {
        if (!kept.empty()) log_.decide("mask: keeps " + percent_text(kept, 1) + " % of the picture");
    }
    void take_depths_of(readers::DepthFile depth, const ResolvedCalibration& resolved, RunInput& input);
    void tell_camera(const RunInput& input) { log_.decide("calibration: " + input.camera_text()); }
    void warn_of_focal(const ResolvedCalibration& camera) {
        if (!camera.focal_doubt.empty()) log_.warn(camera.focal_doubt);
    }
    void warn_of_scale(const ResolvedCalibration& camera) {
        if (const std::string missing = missing_for_metres(camera); !missing.empty()) log_.warn(missing);
    }

    const config::InputConfig& config_;
    const readers::ReaderLimits& limits_;
    int threads_;
    RunLog& log_;
    bool foresees_;                         // only a pair's left picture is needed once it is aligned
    std::optional<Calibration> container_;  // the camera that the pair's own file says
};

// Replaces the pair by its rectified views if its calibration describes unrectified cameras.
void InputReader::rectify_pair(RunInput& input) {
    InputPair& pair = std::get<InputPair>(input.views);
    const ViewSize size = size_of(pair.views.left);
    FileRectification done = rectify_by_file(pair.views, config_, threads_);
    tell(done);
    if (!done.is_done) return;
    input.calibration = done.calibration;
    pair.is_rectified = true;
    if (std::ranges::count(done.seen, 0) > 0) input.mask = {size.width, size.height, std::move(done.seen)};
    if (!done.other_file.empty()) input.files.push_back(hashed("calibration", done.other_file));
}

// Replaces an uncalibrated pair by its aligned views if its rows are off.
void InputReader::align(RunInput& input, const ResolvedCalibration& camera, const PairToAlign& given) {
    InputPair& pair = std::get<InputPair>(input.views);
    PairAlignment done = align_pair(pair.views,
                                    {camera.calibration, camera.is_focal_known, camera.is_baseline_known,
                                     camera.focal_from, camera.baseline_from},
                                    given, threads_);
    input.calibration = done.camera.calibration;
    input.focal_from = done.camera.focal_from;
    input.baseline_from = done.camera.baseline_from;
    pair.is_rectified |= is_aligned(done.found);
    if (is_aligned(done.found)) {
        input.mask = {pair.views.left.width, pair.views.left.height, std::move(done.seen)};
        pair.right_mask = {pair.views.left.width, pair.views.left.height, std::move(done.right_seen)};
    }
    tell(done);
    pair.alignment = std::move(done.found);
}

void restrict_to(const readers::PixelMask& mask, RunInput& input) {
    input.mask = both(std::move(input.mask), mask);
    if (auto* const pair = std::get_if<InputPair>(&input.views))
        pair->is_masked |= std::ranges::count(mask.kept, 0) > 0;
}

void InputReader::hide_strips(RunInput& input) {
    const readers::PixelMask bright = without_dark_strips(input.color());
    if (bright.empty()) return;
    log_.decide("dark strips along the sides: " + percent_text(bright, 0) + " % of the picture, unknown");
    restrict_to(bright, input);
}

// Finds the calibration and adds its file to the input. photograph: the file whose EXIF data describe the
// left view's lens; empty = none.
ResolvedCalibration InputReader::find_camera(RunInput& input, ViewSize view, const fs::path& photograph) {
    const config::CalibrationConfig& config = config_.calibration;
    const Calibration rectified = input.calibration;
    const Image& picture = input.texture();
    const bool is_rectified = input.pair() && input.pair()->is_rectified;
    ResolvedCalibration resolved = resolve_calibration(
        {config, view, picture.empty() ? view : size_of(picture), is_rectified ? &rectified : nullptr,
         photograph, container_ ? &*container_ : nullptr, input.files.empty() ? "" : input.files[0].path});
    if (!picture.empty() && size_of(picture) != view)
        log_.decide("picture: " + size_text(size_of(picture)) + " px, scaled to the map's " +
                    size_text(view) + " px; the texture keeps its size");
    input.calibration = resolved.calibration;
    input.focal_from = resolved.focal_from;
    input.baseline_from = resolved.baseline_from;
    if (!config.file.empty()) input.files.push_back(hashed("calibration", config.file));
    if (!resolved.other_file.empty()) input.files.push_back(hashed("calibration", resolved.other_file));
    tell(resolved);
    return resolved;
}

// Restricts the input's mask, which may hold what a rectified view shows, by the given mask and the picture's
// transparency. Returns it restricted further to pixels of sufficient confidence; empty = all. The two differ
// because a sparse map is filled across pixels of low confidence, but not at pixels that the mask hides.
void InputReader::read_mask(RunInput& input, ViewSize view, MaskSource mask) {
    if (config_.mask.alpha) {
        // take_picture() has checked that the aspects agree.
        if (const readers::PixelMask opaque = opaque_part(input.texture()); !opaque.empty()) {
            restrict_to(readers::resampled(opaque, view.width, view.height), input);
            log_.decide("alpha: " + percent_text(opaque, 0) +
                        " % of the picture is transparent, and unknown");
        }
    }
    if (!mask.file.empty()) mask.array = readers::read_mask(mask.file, config_.mask, limits_);
    if (!mask.array.empty()) restrict_to(fitted(mask.array, view, input.texture(), mask.name("mask")), input);
    if (!mask.file.empty()) input.files.push_back(hashed("mask", mask.file));
}

readers::PixelMask InputReader::read_masks(RunInput& input, ViewSize view, MaskSource mask,
                                           MaskSource confidence) {
    read_mask(input, view, std::move(mask));
    readers::PixelMask kept = input.mask;
    if (!confidence.file.empty())
        confidence.array = readers::read_confidence(confidence.file, config_.confidence, limits_);
    if (!confidence.array.empty())
        kept = both(std::move(kept),
                    fitted(confidence.array, view, input.texture(), confidence.name("confidence")));
    if (!confidence.file.empty()) input.files.push_back(hashed("confidence", confidence.file));
    tell_mask(kept);
    return kept;
}

// Depths need only the focal length of the camera; a missing baseline is chosen by take_depths().
void InputReader::take_depths_of(readers::DepthFile depth, const ResolvedCalibration& resolved,
                                 RunInput& input) {
    Calibration& camera = input.calibration;
    if (!resolved.is_baseline_known) camera.baseline_m = 0;
    if (!resolved.is_focal_known)
        log_.warn(
            "the focal length is not known and taken to be the picture's width, so depths may be stretched; "
            "give --calib FILE, --fov-x DEG or input.calibration.focal_px");
    if (!depth.doubt.empty()) log_.warn(depth.doubt);
    InputMap& map = std::get<InputMap>(input.views);
    map.is_depth = true;
    map.read_as = depth.believed + (config_.depth.ray ? ", along the ray" : "");
    DepthInput taken = take_depths(std::move(depth), config_.depth, resolved.is_focal_known, camera);
    map.disparities = std::move(taken.map);
    if (taken.is_baseline_chosen) input.baseline_from = "the nearest distance";
    for (const std::string& decision : taken.decisions) log_.decide(decision);
}

}  // namespace

const std::vector<fs::path>& rectified_file_names() {
    static const std::vector<fs::path> names = {"left_rectified.png", "right_rectified.png", "calib.txt"};
    return names;
}

RunInput read_input(Source source, const config::InputConfig& config, const readers::ReaderLimits& limits,
                    int threads, RunLog& log) {
    InputReader reader(config, limits, threads, log, false);
    return std::visit([&](auto& given) { return reader.read(given); }, source);
}

RunInput foresee_input(Source source, const config::InputConfig& config, const readers::ReaderLimits& limits,
                       int threads, RunLog& log) {
    InputReader reader(config, limits, threads, log, true);
    return std::visit([&](auto& given) { return reader.read(given); }, source);
}

}  // namespace hexrelief::job
