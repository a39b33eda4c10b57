#include "pipeline/readers/windows/map_windows.h"

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/windows/window_source.h"

namespace hexrelief::readers {
namespace {

std::unique_ptr<WindowSource> open_source(const std::filesystem::path& path, const MapWindowConfig& config) {
    if (config.disparity.flip)
        readers::codec::refuse(path, "rows in the other order are not read in windows; flip the map before");
    if (config.raw) return raw_windows(std::make_shared<MapFile>(path), *config.raw);
    const readers::codec::Codec& codec =
        readers::codec::require_codec(path, "a disparity map as TIFF, BigTIFF or PFM");
    if (codec.format == readers::codec::Format::tiff) return tiff_windows(std::make_shared<MapFile>(path));
    if (codec.format == readers::codec::Format::pfm) return pfm_windows(std::make_shared<MapFile>(path));
    readers::codec::refuse(
        path, std::string(codec.name) + " cannot be read in windows; give the map as TIFF or PFM");
}

}  // namespace

MapWindows::MapWindows(std::filesystem::path path, const MapWindowConfig& config)
    : path_(std::move(path)), config_(config.disparity), source_(open_source(path_, config)) {}

MapWindows::~MapWindows() = default;

std::unique_ptr<MapWindows> MapWindows::open(const std::filesystem::path& path,
                                             const MapWindowConfig& config) {
    std::unique_ptr<MapWindows> map(new MapWindows(path, config));
    readers::disparities_of_part(no_samples(*map->source_), path,
                                 config.disparity);  // refuses a missing scale
    return map;
}

int MapWindows::width() const {
    return source_->width;
}

int MapWindows::height() const {
    return source_->height;
}

DisparityMap MapWindows::read(int x, int y, int width, int height) const {
    return readers::disparities_of_part(read_window(*source_, path_, {x, y, width, height}), path_, config_);
}

}  // namespace hexrelief::readers
