#include "pipeline/tiles/planned_map.h"

#include <algorithm>

#include "mesher/tiles/tile_surface.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief {
namespace {

// Files are in tiles of mostly 256 px, each of which one thread is to decode.
constexpr int kFileTile_px = 256;
constexpr long long kBandPixels = 1 << 24;

}  // namespace

PlannedMap::PlannedMap(const std::filesystem::path& path, const MapWindowConfig& config)
    : map_(MapWindows::open(path, config)) {
    if (std::max(width(), height()) > kLargestTiledSide_px)
        throw Error(ErrorKind::input, path.string() + ": tiles are for maps of up to " +
                                          std::to_string(kLargestTiledSide_px) +
                                          " px a side; cut it into several maps first");
}

void PlannedMap::read_into(const MapRect& window, ThreadPool& pool, DisparityMap& map) const {
    map.width = window.width;
    map.height = window.height;
    map.values.resize(static_cast<std::size_t>(window.width) * window.height);
    const int first_tile = window.x / kFileTile_px,
              tiles = (window.x + window.width - 1) / kFileTile_px + 1 - first_tile;
    pool.parallel_for(static_cast<std::size_t>(tiles), [&](std::size_t first, std::size_t last) {
        const auto edge = [&](std::size_t tile) {
            return std::clamp((first_tile + static_cast<int>(tile)) * kFileTile_px, window.x,
                              window.x + window.width);
        };
        const int left = edge(first), width = edge(last) - left;
        for (int y = 0; y < window.height && width > 0; y += kFileTile_px) {
            DisparityMap part =
                map_->read(left, window.y + y, width, std::min(kFileTile_px, window.height - y));
            rounded_disparities(part);
            for (int row = 0; row < part.height; ++row)
                std::copy_n(&part.values[static_cast<std::size_t>(row) * width], width,
                            &map.at(left - window.x, y + row));
        }
    });
}

DisparityMap PlannedMap::read(const MapRect& window, int threads) const {
    DisparityMap map;
    if (threads > 1) {
        ThreadPool pool(threads);
        read_into(window, pool, map);
    } else {
        map = map_->read(window.x, window.y, window.width, window.height);
        rounded_disparities(map);
    }
    return map;
}

void PlannedMap::read_bands(int threads, const std::function<void(const DisparityMap& band)>& take) const {
    const long long fitting = kBandPixels / width();
    const int rows = static_cast<int>(fitting >= kFileTile_px ? fitting / kFileTile_px * kFileTile_px
                                                              : std::max(16LL, fitting / 2 * 2));
    ThreadPool pool(threads);
    DisparityMap band;
    for (int y = 0; y < height(); y += rows) {
        wait_if_interrupted();
        read_into({0, y, width(), std::min(rows, height() - y)}, pool, band);
        take(band);
    }
}

}  // namespace hexrelief
