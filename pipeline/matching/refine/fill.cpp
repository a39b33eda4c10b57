#include "pipeline/matching/refine/fill.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/refine/fill_step.h"
#include "pipeline/matching/refine/half_size_match_step.h"
#include "pipeline/matching/refine/match_colors.h"

namespace hexrelief::matching {
namespace {

constexpr std::int32_t kNoMatch = -1;
using Sources = std::array<std::int32_t, step::kDirections>;  // pixels as packed() has them

// A pixel in one number; sides of pairs are below 2^15 px.
std::int32_t packed(int x, int y) {
    return y << 16 | x;
}

// The nearest known pixels of each unknown pixel. Unknown pixels are numbered row by row.
class NearestKnown {
  public:
    explicit NearestKnown(DisparityView map) : map_(map), first_of_row_(map.height + 1) {
        for (int y = 0; y < map.height; ++y) {
            const std::int16_t* row = map.row(y);
            first_of_row_[y + 1] = first_of_row_[y] + std::count(row, row + map.width, kUnknown16);
        }
        sources_.resize(static_cast<std::size_t>(first_of_row_.back()));
    }
    // Searches in direction k. A direction leads along the row, to the row above, or to the row below; in the
    // last case rows are visited from the bottom to the top.
    void search(int k) {
        const int dx = step::direction_x(k), dy = step::direction_y(k);
        // There is nothing beside the row.
        std::vector<std::int32_t> before(static_cast<std::size_t>(map_.width) + 2, kNoMatch), here = before;
        for (int i = 0; i < map_.height; ++i) {
            const int y = dy > 0 ? map_.height - 1 - i : i;
            search_row(k, y, dy == 0 ? here : before, dx, here);
            std::swap(before, here);
            if (dy == 0) std::fill(here.begin(), here.end(), kNoMatch);
        }
    }
    long long first_of_row(int y) const { return first_of_row_[static_cast<std::size_t>(y)]; }
    const Sources& of(long long unknown) const { return sources_[static_cast<std::size_t>(unknown)]; }

  private:
    // `from` and `here` are indexed by x + 1.
    void search_row(int k, int y, const std::vector<std::int32_t>& from, int dx,
                    std::vector<std::int32_t>& here) {
        const std::int16_t* row = map_.row(y);
        const bool backward = dx > 0;
        long long unknown = backward ? first_of_row_[y + 1] : first_of_row_[y] - 1;
        for (int i = 0; i < map_.width; ++i) {
            const int x = backward ? map_.width - 1 - i : i;
            std::int32_t& source = here[static_cast<std::size_t>(x) + 1];
            if (row[x] != kUnknown16) {
                source = packed(x, y);
                continue;
            }
            source = from[static_cast<std::size_t>(x + 1 + dx)];
            unknown += backward ? -1 : 1;
            sources_[static_cast<std::size_t>(unknown)][static_cast<std::size_t>(k)] = source;
        }
    }

    DisparityView map_;
    std::vector<long long> first_of_row_;
    std::vector<Sources> sources_;
};

// Returns the disparity at (x, y) of the plane through a known pixel.
int on_plane_of(DisparityView map, const Slopes& slopes, std::int32_t source, int x, int y) {
    if (source == kNoMatch) return kUnknown16;
    const int from_x = source & 0xffff, from_y = source >> 16;
    return step::on_plane(map.at(from_x, from_y), slopes.x.view().at(from_x, from_y),
                          slopes.y.view().at(from_x, from_y), x - from_x, y - from_y);
}

}  // namespace

void add_half_size_matches(const HalfSizeMatches& half, int min_px, TrustedMatches& matches,
                           ThreadPool& pool) {
    const DisparityOut left = matches.left.view();
    const DisparityView half_left = half.left.view(), right = std::as_const(matches.right).view();
    for_each_row(pool, left.height, [&](int y) {
        for (int x = 0; x < left.width; ++x)
            if (left.at(x, y) < 0)
                left.at(x, y) =
                    step::half_size_match(half_left, half.min_px, right.row(y), left.width, min_px, x, y);
    });
}

Disparities16 fill_unknown(const FillInput& input, ThreadPool& pool) {
    const TrustedMatches& matches = input.matches;
    const DisparityView map = matches.left.view();
    const ColorView left = view_of(input.colors.left), right = view_of(input.colors.right);
    NearestKnown nearest(map);
    pool.run([&](int thread) {
        for (int k = thread; k < step::kDirections; k += pool.size()) nearest.search(k);
    });
    Disparities16 result = matches.left;
    const DisparityOut out = result.view();
    for_each_row(pool, map.height, [&](int y) {
        long long unknown = nearest.first_of_row(y);
        for (int x = 0; x < map.width; ++x) {
            if (map.at(x, y) != kUnknown16) continue;
            const Sources& sources = nearest.of(unknown++);
            int candidates[step::kDirections];
            for (std::size_t k = 0; k < sources.size(); ++k)
                candidates[k] = on_plane_of(map, input.slopes, sources[k], x, y);
            const step::FillSite site{x, map.width, input.min_px, matches.nearest_seen.view().row(y),
                                      matches.right.view().row(y)};
            out.at(x, y) = step::filled(site, candidates, [&](int disparity) {
                return window_difference(left, right, x, y,
                                         step::position_in_right(x, input.min_px, disparity));
            });
        }
    });
    return result;
}

}  // namespace hexrelief::matching
