// Finds which neighbouring pixels lie on one surface: the disparity map without speckles,
// with its depth discontinuities.
#pragma once

#include <cstdint>

#include "mesher/common/surface_config.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::surface {

struct PixelSurfaces {
    int width = 0;
    int height = 0;
    float discontinuity_px = 0;
    RawVector<float> disparity;  // px, 0 = no foreground; a speckle has its nearest neighbour's disparity
    // One value per pixel, see step::PixelView::flags, and step::kMorePixelFlags more: see eight_flags.h.
    RawVector<std::uint8_t> flags;

    int tile_columns = 0;                // number of columns of tile_sums
    RawVector<std::uint32_t> tile_sums;  // step::TileView::sums

    // True if a discontinuity lies in or next to the box from a to b, up to the size of a tile.
    bool may_cross(const Vec2f& a, const Vec2f& b) const { return step::may_cross(tiles(), a, b); }
    // True if a discontinuity lies in the box from a to b, where a straight path between them could cross it.
    bool may_meet(const Vec2f& a, const Vec2f& b) const;
    step::TileView tiles() const { return {width, height, tile_columns, tile_sums.data()}; }
    step::PixelView view() const { return {width, height, disparity.data(), flags.data()}; }
};

// Finds the surfaces of a map's pixels. Small regions between discontinuities are speckles: they get the
// disparity of the surrounding region and do not count in fits. Holes of up to a lattice cell, cell_px
// pixels, are filled in the same way.
PixelSurfaces find_pixel_surfaces(const DisparityMap& map, float background_px, double cell_px,
                                  const SurfaceConfig& config, ThreadPool& pool);

}  // namespace hexrelief::surface
