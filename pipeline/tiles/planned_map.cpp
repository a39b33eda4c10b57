#include "pipeline/tiles/planned_map.h"

#include <algorithm>

#include "mesher/tiles/tile_surface.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/tiles/solve_tiles.h"

namespace hexrelief::tiles {
namespace {

// Files have tiles of mostly 256 px, each of which should be decoded by one thread.
constexpr int kFileTile_px = 256;

// Returns the first column of the file's tiles that is right of the window.
int tiles_end(const mesh_tiles::MapRect& window) {
    return (window.x + window.width - 1) / kFileTile_px + 1;
}

}  // namespace

PlannedMap::PlannedMap(const TilePlan& plan, bool needs_colors)
    : map_(readers::MapWindows::open(plan.map.path, {plan.config.input.disparity, plan.raw})),
      picture_(plan.color.path.empty() ? nullptr : readers::PictureWindows::open(plan.color.path)),
      has_transparent_(picture_ && picture_->has_alpha() && plan.config.input.mask.alpha) {
    if (picture_ && (picture_->width() != width() || picture_->height() != height()))
        throw Error(ErrorKind::input, plan.color.path.string() + ": is " +
                                          job::size_text({picture_->width(), picture_->height()}) +
                                          " px, the map " + job::size_text({width(), height()}) +
                                          "; of tiles they must be of one size");
    if (std::max(width(), height()) > kLargestTiledSide_px)
        throw Error(ErrorKind::input, plan.map.path.string() + ": tiles are for maps of up to " +
                                          std::to_string(kLargestTiledSide_px) +
                                          " px a side; cut it into several maps first");
    if (!needs_colors && !has_transparent_) picture_.reset();
}

int PlannedMap::strips_of(const mesh_tiles::MapRect& window, int threads) {
    return std::clamp(tiles_end(window) - window.x / kFileTile_px, 1, std::max(1, threads));
}

void PlannedMap::read_in_strips(
    const mesh_tiles::MapRect& window, int strips,
    const std::function<void(int strip, const stages::MapWindow& part)>& take) const {
    const int first = window.x / kFileTile_px, tiles = tiles_end(window) - first,
              right = window.x + window.width, bottom = window.y + window.height;
    do_jobs(static_cast<std::size_t>(strips), strips, [&](std::size_t k) {
        const int strip = static_cast<int>(k);
        const auto edge = [&](int of) {
            return std::clamp((first + tiles * of / strips) * kFileTile_px, window.x, right);
        };
        const int x = edge(strip), width = edge(strip + 1) - x;
        for (int y = window.y, next = 0; y < bottom; y = next) {
            files::wait_if_interrupted();
            next = std::min((y / kFileTile_px + 1) * kFileTile_px, bottom);
            const DisparityMap part = read({x, y, width, next - y});
            take(strip, {x, y, width, part.height, part.values.data(), static_cast<std::size_t>(width)});
        }
    });
}

// Hides in bands, so that the picture's samples need little memory beside the map's.
void PlannedMap::hide_transparent(const mesh_tiles::MapRect& window, DisparityMap& map) const {
    for (int top = 0; top < window.height; top += kFileTile_px) {
        const int rows = std::min(kFileTile_px, window.height - top);
        const Image part = picture_->read(window.x, window.y + top, window.width, rows);
        float* const values = map.values.data() + static_cast<std::size_t>(top) * window.width;
        for (std::size_t i = 0; i < part.alpha.size(); ++i)
            if (part.alpha[i] < kOpaque) values[i] = kUnknownDisparity;
    }
}

DisparityMap PlannedMap::read(const mesh_tiles::MapRect& window, int threads) const {
    const int strips = strips_of(window, threads);
    if (strips == 1) {
        DisparityMap map = map_->read(window.x, window.y, window.width, window.height);
        if (has_transparent_) hide_transparent(window, map);
        mesh_tiles::rounded_disparities(map);
        return map;
    }
    DisparityMap map{window.width, window.height, {}};
    map.values.resize(static_cast<std::size_t>(window.width) * window.height);
    read_in_strips(window, strips, [&](int, const stages::MapWindow& part) {
        for (int row = 0; row < part.height; ++row)
            std::copy_n(part.row(row), part.width, &map.at(part.x - window.x, part.y - window.y + row));
    });
    return map;
}

stages::MapInStrips PlannedMap::strips(int threads) const {
    const mesh_tiles::MapRect all{0, 0, width(), height()};
    const int strips = strips_of(all, threads);
    return {strips, [this, all, strips](const auto& take) { read_in_strips(all, strips, take); }};
}

}  // namespace hexrelief::tiles
