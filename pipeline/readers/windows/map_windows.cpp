#include "pipeline/readers/windows/map_windows.h"

#include <algorithm>

#include "pipeline/data/shrink.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/windows/window_source.h"

namespace hexrelief::readers {
namespace {

std::unique_ptr<WindowSource> open_source(const std::filesystem::path& path, const MapWindowConfig& config) {
    if (config.disparity.flip)
        codec::refuse(path, "rows in the other order are not read in windows; flip the map before");
    if (config.raw) return raw_windows(std::make_shared<MapFile>(path), *config.raw);
    const codec::Codec& codec = codec::require_codec(path, "a disparity map as TIFF, BigTIFF or PFM");
    if (codec.format == codec::Format::tiff) return tiff_windows(std::make_shared<MapFile>(path));
    if (codec.format == codec::Format::pfm) return pfm_windows(std::make_shared<MapFile>(path));
    codec::refuse(path, std::string(codec.name) + " cannot be read in windows; give the map as TIFF or PFM");
}

// A picture that is held in memory as a whole.
class WholePicture : public WindowSource {
  public:
    explicit WholePicture(Image image) : image_(std::move(image)) {
        width = image_.width;
        height = image_.height;
        channels = image_.channels;
        has_alpha = !image_.alpha.empty();
        sample = MapSample::uint8;
    }

    codec::Raster read(const codec::PixelWindow& window) const override {
        codec::Raster part{.width = static_cast<int>(window.width),
                           .height = static_cast<int>(window.height),
                           .channels = image_.channels};
        std::vector<std::uint8_t> pixels;
        pixels.reserve(static_cast<std::size_t>(window.width) * window.height * image_.channels);
        for (std::uint32_t y = window.y; y < window.y + window.height; ++y) {
            const std::size_t first = static_cast<std::size_t>(y) * image_.width + window.x;
            append(image_.pixels, first * image_.channels, window.width * image_.channels, pixels);
            if (!image_.alpha.empty()) append(image_.alpha, first, window.width, part.alpha);
        }
        part.samples = std::move(pixels);
        if (std::ranges::none_of(part.alpha, [](std::uint8_t alpha) { return alpha < kOpaque; }))
            part.alpha.clear();
        return part;
    }

  private:
    static void append(const std::vector<std::uint8_t>& from, std::size_t at, std::size_t count,
                       std::vector<std::uint8_t>& to) {
        const auto first = from.begin() + static_cast<std::ptrdiff_t>(at);
        to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(count));
    }

    Image image_;
};

std::unique_ptr<WindowSource> open_source(const std::filesystem::path& path, const ReaderLimits& limits) {
    const codec::Codec* const codec = codec::find_codec(path);
    std::unique_ptr<WindowSource> source;
    if (codec && codec->format == codec::Format::pnm) source = pnm_windows(std::make_shared<MapFile>(path));
    if (codec && codec->format == codec::Format::tiff)
        source = tiff_picture_windows(std::make_shared<MapFile>(path));
    return source ? std::move(source) : std::make_unique<WholePicture>(read_image(path, limits));
}

}  // namespace

MapWindows::MapWindows(const std::filesystem::path& path, const MapWindowConfig& config)
    : FileWindows(path, open_source(path, config)), config_(config.disparity) {}

std::unique_ptr<MapWindows> MapWindows::open(const std::filesystem::path& path,
                                             const MapWindowConfig& config) {
    std::unique_ptr<MapWindows> map(new MapWindows(path, config));
    disparities_of_part(no_samples(*map->source_), path,
                        config.disparity);  // refuses a missing scale
    return map;
}

DisparityMap MapWindows::read(int x, int y, int width, int height) const {
    return disparities_of_part(read_window(*source_, path_, {x, y, width, height}), path_, config_);
}

std::unique_ptr<PictureWindows> PictureWindows::open(const std::filesystem::path& path,
                                                     const ReaderLimits& limits) {
    std::unique_ptr<PictureWindows> picture(new PictureWindows(path, open_source(path, limits)));
    image_of(no_samples(*picture->source_), path);  // refuses floats, which are not a picture
    return picture;
}

Image PictureWindows::read(int x, int y, int width, int height) const {
    return image_of(read_window(*source_, path_, {x, y, width, height}), path_);
}

Image PictureWindows::read_shrunk(int x, int y, int width, int height, int by) const {
    Image out{0, 0, channels(), {}};
    const int band_rows = std::max(by, (1 << 24) / std::max(1, width) / by * by);
    for (int top = 0; top < height; top += band_rows) {
        const Image band = shrunk(read(x, y + top, width, std::min(band_rows, height - top)), by);
        out.width = band.width;
        out.height += band.height;
        out.pixels.insert(out.pixels.end(), band.pixels.begin(), band.pixels.end());
    }
    return out;
}

}  // namespace hexrelief::readers
