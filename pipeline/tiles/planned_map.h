// The map of a plan, read in windows and in strips.
#pragma once

#include <functional>
#include <memory>

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
    // All of it, by `threads` threads.
    MapInStrips strips(int threads) const;

  private:
    static int strips_of(const MapRect& window, int threads);
    void read_in_strips(const MapRect& window, int strips,
                        const std::function<void(int strip, const MapWindow& part)>& take) const;
    std::unique_ptr<MapWindows> map_;
};

}  // namespace hexrelief
