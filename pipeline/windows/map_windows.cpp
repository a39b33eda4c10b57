#include "pipeline/windows/map_windows.h"

#include <algorithm>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/windows/window_source.h"

namespace hexrelief {
namespace {

std::string size_text(long long width, long long height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

std::unique_ptr<WindowSource> open_source(const std::filesystem::path& path, const MapWindowConfig& config) {
    if (config.raw) return raw_windows(std::make_shared<MapFile>(path), *config.raw);
    const codec::Codec& codec = codec::require_codec(path, "a disparity map as TIFF, BigTIFF or PFM");
    if (codec.format == codec::Format::tiff) return tiff_windows(std::make_shared<MapFile>(path));
    if (codec.format == codec::Format::pfm) return pfm_windows(std::make_shared<MapFile>(path));
    codec::refuse(path, std::string(codec.name) + " cannot be read in windows; give the map as TIFF or PFM");
}

codec::Raster no_samples(MapSample sample) {
    codec::Raster raster;
    if (sample == MapSample::uint16) raster.samples = std::vector<std::uint16_t>();
    if (sample == MapSample::float32) raster.samples = std::vector<float>();
    return raster;
}

}  // namespace

void check_map_size(const std::filesystem::path& path, unsigned long long width, unsigned long long height) {
    if (width == 0 || height == 0)
        codec::refuse(path, "its size is " + std::to_string(width) + "x" + std::to_string(height) +
                                "; both sides must be at least 1");
    if (std::max(width, height) > kLargestMapSide_px)
        codec::refuse(path, "its size is " + std::to_string(width) + "x" + std::to_string(height) +
                                ", more than the limit of " + std::to_string(kLargestMapSide_px) +
                                " px a side; cut it into several maps first");
}

MapWindows::MapWindows(std::filesystem::path path, const MapWindowConfig& config)
    : path_(std::move(path)), config_(config.disparity), source_(open_source(path_, config)) {}

MapWindows::~MapWindows() = default;

std::unique_ptr<MapWindows> MapWindows::open(const std::filesystem::path& path,
                                             const MapWindowConfig& config) {
    std::unique_ptr<MapWindows> map(new MapWindows(path, config));
    disparities_of_part(no_samples(map->source_->sample), path, config.disparity);  // a scale that is missing
    return map;
}

int MapWindows::width() const {
    return source_->width;
}

int MapWindows::height() const {
    return source_->height;
}

DisparityMap MapWindows::read(int x, int y, int width, int height) const {
    const auto within = [](long long at, long long size, long long all) {
        return at >= 0 && size >= 1 && at + size <= all;
    };
    if (!within(x, width, source_->width) || !within(y, height, source_->height))
        codec::refuse(path_, "there is no window of " + size_text(width, height) + " px at " +
                                 std::to_string(x) + "," + std::to_string(y) + " in its " +
                                 size_text(source_->width, source_->height) + " px; ask for one inside");
    if (static_cast<long long>(width) * height > kMaxPixels)
        codec::refuse(path_, "a window of " + size_text(width, height) + " px is above the limit of " +
                                 std::to_string(kMaxPixels) + " pixels; ask for smaller ones");
    const auto at = [](int value) { return static_cast<std::uint32_t>(value); };
    return disparities_of_part(source_->read({at(x), at(y), at(width), at(height)}), path_, config_);
}

}  // namespace hexrelief
