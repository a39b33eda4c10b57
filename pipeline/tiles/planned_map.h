// The map of a plan, read in windows and in bands.
#pragma once

#include <memory>

#include "mesher/common/thread_pool.h"
#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/stages/density.h"
#include "pipeline/windows/map_windows.h"

namespace hexrelief {

class PlannedMap {
  public:
    // Throws Error(input) as MapWindows::open(), and for more than kLargestTiledSide_px a side.
    PlannedMap(const std::filesystem::path& path, const MapWindowConfig& config);

    int width() const { return map_->width(); }
    int height() const { return map_->height(); }
    // Disparities as rounded_disparities() leaves them, read by `threads` threads. Any number of threads may
    // call. Throws as MapWindows::read().
    DisparityMap read(const MapRect& window, int threads = 1) const;
    // All rows from the top, in bands of an even number of rows (but for the last) that `threads` threads
    // read.
    void read_bands(int threads, const std::function<void(const DisparityMap& band)>& take) const;

  private:
    void read_into(const MapRect& window, ThreadPool& pool, DisparityMap& map) const;
    std::unique_ptr<MapWindows> map_;
};

}  // namespace hexrelief
