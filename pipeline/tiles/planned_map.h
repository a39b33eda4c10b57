// The map and the picture of a plan, read in windows and in strips.
#pragma once

#include <functional>
#include <memory>

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/stages/density.h"
#include "pipeline/tiles/tile_plan.h"
#include "pipeline/windows/map_windows.h"
#include "pipeline/windows/picture_windows.h"

namespace hexrelief::tiles {

class PlannedMap {
  public:
    // Of the plan's map, picture and configuration. A picture is kept where its colours are needed or its
    // pixels may be transparent: it may be large. Throws Error(input) as MapWindows::open() and
    // PictureWindows::open(), for a picture of another size, and for more than kLargestTiledSide_px a side.
    PlannedMap(const TilePlan& plan, bool needs_colors);

    int width() const { return map_->width(); }
    int height() const { return map_->height(); }
    const windows::PictureWindows* picture() const { return picture_.get(); }  // null where none is kept
    // Disparities as rounded_disparities() leaves them, read by `threads` threads; unknown where the picture
    // is transparent and input.mask.alpha says so. Any number of threads may call. Throws as
    // MapWindows::read() and PictureWindows::read().
    DisparityMap read(const mesh_tiles::MapRect& window, int threads = 1) const;
    // All of it, by `threads` threads.
    stages::MapInStrips strips(int threads) const;

  private:
    static int strips_of(const mesh_tiles::MapRect& window, int threads);
    void read_in_strips(const mesh_tiles::MapRect& window, int strips,
                        const std::function<void(int strip, const stages::MapWindow& part)>& take) const;
    void hide_transparent(const mesh_tiles::MapRect& window, DisparityMap& map) const;
    std::unique_ptr<windows::MapWindows> map_;
    std::unique_ptr<windows::PictureWindows> picture_;
    bool has_transparent_ = false;
};

}  // namespace hexrelief::tiles
