#include "pipeline/tiles/planned_map.h"

#include <algorithm>

#include "mesher/common/thread_pool.h"
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

DisparityMap PlannedMap::read(const MapRect& window) const {
    DisparityMap map = map_->read(window.x, window.y, window.width, window.height);
    rounded_disparities(map);
    return map;
}

void PlannedMap::read_bands(int threads, const std::function<void(const DisparityMap& band)>& take) const {
    const long long fitting = kBandPixels / width();
    const int rows = static_cast<int>(fitting >= kFileTile_px ? fitting / kFileTile_px * kFileTile_px
                                                              : std::max(16LL, fitting / 2 * 2));
    const int columns = (width() + kFileTile_px - 1) / kFileTile_px;  // of the file's tiles
    ThreadPool pool(threads);
    DisparityMap band{width(), 0, {}};
    for (int y = 0; y < height(); y += rows) {
        wait_if_interrupted();
        band.height = std::min(rows, height() - y);
        band.values.resize(static_cast<std::size_t>(width()) * band.height);
        pool.parallel_for(static_cast<std::size_t>(columns), [&](std::size_t first, std::size_t last) {
            const int left = static_cast<int>(first) * kFileTile_px,
                      right = std::min(width(), static_cast<int>(last) * kFileTile_px);
            if (left >= right) return;
            const DisparityMap part = read({left, y, right - left, band.height});
            for (int row = 0; row < part.height; ++row)
                std::copy_n(&part.values[static_cast<std::size_t>(row) * part.width], part.width,
                            &band.at(left, row));
        });
        take(band);
    }
}

}  // namespace hexrelief
