// Reads the map and the picture of a plan in windows and in strips.
#pragma once

#include <functional>
#include <memory>

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/readers/windows/map_windows.h"
#include "pipeline/stages/density.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

class PlannedMap {
  public:
    // Opens the plan's map and picture. The picture is kept only if its colours are needed or its
    // pixels may be transparent, because it may be large. Throws Error(input) as
    // MapWindows::open() and PictureWindows::open() do, if the picture has another size, and if a
    // side has more than kLargestTiledSide_px.
    PlannedMap(const TilePlan& plan, bool needs_colors);

    int width() const { return map_->width(); }
    int height() const { return map_->height(); }
    const readers::PictureWindows* picture() const { return picture_.get(); }  // null if none is kept
    // Returns a window's disparities, rounded by rounded_disparities() and read by `threads` threads; unknown
    // where the picture is transparent if input.mask.alpha is set. Any number of threads may call. Throws
    // what MapWindows::read() and PictureWindows::read() throw.
    DisparityMap read(const mesh_tiles::MapRect& window, int threads = 1) const;
    // Returns the whole map in strips, to be read by `threads` threads.
    stages::MapInStrips strips(int threads) const;

  private:
    static int strips_of(const mesh_tiles::MapRect& window, int threads);
    void read_in_strips(const mesh_tiles::MapRect& window, int strips,
                        const std::function<void(int strip, const stages::MapWindow& part)>& take) const;
    void hide_transparent(const mesh_tiles::MapRect& window, DisparityMap& map) const;
    std::unique_ptr<readers::MapWindows> map_;
    std::unique_ptr<readers::PictureWindows> picture_;
    bool has_transparent_ = false;
};

}  // namespace hexrelief::tiles
