#include "pipeline/library/conversions.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "pipeline/config/key_options.h"
#include "pipeline/config/options.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::library {
namespace {

// Returns `height` rows of `row` samples, without the gaps between rows.
template <typename Sample>
std::vector<Sample> rows_of(const void* from, std::size_t row, int height, std::size_t row_bytes) {
    std::vector<Sample> samples(row * static_cast<std::size_t>(height));
    const std::size_t bytes = row * sizeof(Sample), step = row_bytes > 0 ? row_bytes : bytes;
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
        std::memcpy(samples.data() + y * row, static_cast<const std::uint8_t*>(from) + y * step, bytes);
    return samples;
}

void require_pixels(const void* values, int width, int height, const std::string& name) {
    if (values == nullptr || width < 1 || height < 1)
        throw Error(ErrorKind::input, name + ": it has no pixels; give an array of height x width");
}

// Moves the last channel to the image's alpha, which is dropped if all pixels are opaque, as the
// readers of files do.
void split_alpha(Image& image) {
    const auto all = static_cast<std::size_t>(image.channels), colors = all - 1;
    const std::size_t pixels = image.pixels.size() / all;
    bool is_opaque = true;
    image.alpha.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        image.alpha[i] = image.pixels[i * all + colors];
        is_opaque = is_opaque && image.alpha[i] >= kOpaque;
        for (std::size_t c = 0; c < colors; ++c) image.pixels[i * colors + c] = image.pixels[i * all + c];
    }
    image.pixels.resize(pixels * colors);
    image.channels = static_cast<int>(colors);
    if (is_opaque) image.alpha.clear();
}

readers::codec::Raster raster_of(const MapView& view, const std::string& name) {
    require_pixels(view.values, view.width, view.height, name);
    readers::codec::Raster raster;
    raster.width = view.width;
    raster.height = view.height;
    const auto row = static_cast<std::size_t>(view.width);
    if (view.samples == MapView::Samples::float32)
        raster.samples = rows_of<float>(view.values, row, view.height, view.row_bytes);
    else if (view.samples == MapView::Samples::uint16)
        raster.samples = rows_of<std::uint16_t>(view.values, row, view.height, view.row_bytes);
    else
        raster.samples = rows_of<std::uint8_t>(view.values, row, view.height, view.row_bytes);
    return raster;
}

config::Config configured(const Options& options, const Camera& camera, const std::vector<std::string>& files,
                          const config::Config& base) {
    std::vector<std::string> settings;
    for (const auto& [key, value] : options.settings) settings.push_back(key + "=" + value);
    config::Config config = config::read_config(options.config, settings, base);
    const auto take = [&](const char* name, double value) {
        if (!std::isnan(value))
            config::apply_option(config, std::string("camera.") + name,
                                 std::string("input.calibration.") + name, value);
    };
    if (!camera.file.empty())
        config::apply_option(config, "camera.file", "input.calibration.file", camera.file);
    take("focal_px", camera.focal_px);
    take("baseline_m", camera.baseline_m);
    take("cx", camera.cx);
    take("cy", camera.cy);
    take("doffs_px", camera.doffs_px);
    apply_options(config, options.direct, files);
    return config;
}

}  // namespace

Image image_of(const ImageView& view, const std::string& name) {
    require_pixels(view.pixels, view.width, view.height, name);
    if (view.channels < 1 || view.channels > 4)
        throw Error(ErrorKind::input,
                    name + ": it has " + std::to_string(view.channels) +
                        " channels; give 1 (grey) or 3 (red, green, blue), with alpha 2 or 4");
    const auto channels = static_cast<std::size_t>(view.channels);
    const std::size_t row = static_cast<std::size_t>(view.width) * channels;
    Image image{view.width, view.height, view.channels,
                rows_of<std::uint8_t>(view.pixels, row, view.height, view.row_bytes)};
    if (channels % 2 == 0) split_alpha(image);
    return image;
}

readers::DisparityFile map_of(const MapView& view, const readers::DisparityFileConfig& config) {
    return readers::disparities_of(raster_of(view, "disparity"), "disparity", readers::before_doffs(config));
}

readers::DepthFile depth_of(const MapView& view, const readers::DepthFileConfig& config) {
    return readers::depths_of(raster_of(view, "depth"), "depth", config);
}

readers::PixelMask mask_of(const ImageView& view, const readers::MaskConfig& config) {
    Image image = image_of(view, "mask");
    readers::codec::Raster raster;
    raster.width = image.width;
    raster.height = image.height;
    raster.channels = image.channels;
    raster.samples = std::move(image.pixels);
    raster.alpha = std::move(image.alpha);
    return readers::mask_of(raster, "mask", config);
}

readers::PixelMask confidence_of(const MapView& view, const readers::ConfidenceConfig& config) {
    return readers::confidence_of(raster_of(view, "confidence"), "confidence", config);
}

config::Config config_of(const Options& options, const Camera& camera,
                         const std::vector<std::string>& files) {
    config::Config config = configured(options, camera, files, {});
    if (options.config.empty())
        config = configured(options, camera, files, config::budget_base(config.budget));
    config::finish_config(config);
    return config;
}

void apply_export_settings(config::Config& config, const Options& options) {
    if (!options.config.empty())
        throw Error(ErrorKind::usage, "save() takes settings of 'export', not a configuration");
    for (const auto& [key, value] : options.settings) {
        if (!key.starts_with("export."))
            throw Error(ErrorKind::usage,
                        "'" + key + "' is not a setting of 'export'; give it where the mesh is made");
        config::apply_setting(config, key + "=" + value);
    }
    config::finish_config(config);
}

bool sets_tolerance(const Options& options) {
    return std::any_of(options.settings.begin(), options.settings.end(),
                       [](const auto& setting) { return setting.first.starts_with("export.tolerance_"); });
}

}  // namespace hexrelief::library
