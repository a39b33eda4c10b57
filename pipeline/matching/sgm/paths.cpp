#include "pipeline/matching/sgm/paths.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "mesher/common/simd.h"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/sgm/costs.h"

namespace hexrelief {
namespace {

using Cost = std::uint16_t;
using PenaltyTable = std::array<Cost, 256>;  // of large steps, by the colour's step

// The costs of paths at the pixels before and here, side by side for several paths.
class PathCosts {
  public:
    PathCosts(int paths, int count)
        : paths_(static_cast<std::size_t>(paths)),
          count_(count),
          stride_(static_cast<std::size_t>(count) + 2 * kPad),
          values_(2 * paths_ * stride_, step::kNoPath),
          least_(2 * paths_) {}

    // A path that begins costs nothing before.
    void begin(int path, int parity) {
        std::fill_n(at(path, parity), count_, Cost{0});
        least(path, parity) = 0;
    }
    // Writable from -1 to count: what lies beside the range stays kNoPath.
    Cost* at(int path, int parity) { return values_.data() + index(path, parity) * stride_ + kPad; }
    Cost& least(int path, int parity) { return least_[index(path, parity)]; }

  private:
    static constexpr int kPad = 32;
    std::size_t index(int path, int parity) const { return parity * paths_ + path; }

    std::size_t paths_;
    int count_;
    std::size_t stride_;
    std::vector<Cost> values_, least_;
};

enum class Sums { set, add };

// One pixel of a path: from its costs at the pixel before to those here, which go into the sums. Returns the
// least of them.
template <Sums kSums>
HEXRELIEF_INLINED Cost advance(const Cost* __restrict before, Cost least,
                               const std::uint8_t* __restrict costs, Cost p1, Cost p2, int count,
                               Cost* __restrict here, Cost* __restrict sums) {
    Cost best = 0xffff;
    for (int d = 0; d < count; ++d) {
        const Cost cost = step::path_cost(before[d], before[d - 1], before[d + 1], least, p1, p2, costs[d]);
        here[d] = cost;
        sums[d] = kSums == Sums::set ? cost : static_cast<Cost>(sums[d] + cost);
        best = best < cost ? best : cost;
    }
    return best;
}

// p2[x]: of a large step between pixels x - 1 and x.
HEXRELIEF_SMALL_VECTORS void paths_along_row(const std::uint8_t* costs, const Cost* p2, Cost p1, int width,
                                             int count, PathCosts& paths, Cost* sums) {
    paths.begin(0, 1);
    for (int x = 0; x < width; ++x) {
        const int here = x & 1, before = here ^ 1;
        const std::size_t at = static_cast<std::size_t>(x) * count;
        paths.least(0, here) = advance<Sums::set>(paths.at(0, before), paths.least(0, before), costs + at, p1,
                                                  p2[x], count, paths.at(0, here), sums + at);
    }
    paths.begin(0, 1);
    for (int i = 0; i < width; ++i) {
        const int x = width - 1 - i, here = i & 1, before = here ^ 1;
        const std::size_t at = static_cast<std::size_t>(x) * count;
        paths.least(0, here) = advance<Sums::add>(paths.at(0, before), paths.least(0, before), costs + at, p1,
                                                  p2[x + 1], count, paths.at(0, here), sums + at);
    }
}

int color_step(const ColorView& colors, int x, int y, int other_x, int other_y) {
    int largest = 0;
    for (int c = 0; c < colors.channels; ++c) {
        const auto& plane = colors.planes[c];
        largest = std::max<int>(largest, step::distance(plane.at(x, y), plane.at(other_x, other_y)));
    }
    return largest;
}

enum class Direction { down, up };
struct Columns {
    int first, end;
};

HEXRELIEF_SMALL_VECTORS void paths_along_columns(const ColorView& colors, const PenaltyTable& p2, Cost p1,
                                                 Columns columns, Direction direction, PathCosts& paths,
                                                 MatchingVolume& volume) {
    for (int x = columns.first; x < columns.end; ++x) paths.begin(x - columns.first, 1);
    for (int i = 0; i < volume.rows; ++i) {
        const bool down = direction == Direction::down;
        const int y = volume.first_row + (down ? i : volume.rows - 1 - i), from = down ? y - 1 : y + 1;
        const int here = i & 1, before = here ^ 1;
        for (int x = columns.first; x < columns.end; ++x) {
            const int path = x - columns.first;
            paths.least(path, here) =
                advance<Sums::add>(paths.at(path, before), paths.least(path, before), volume.costs_at(x, y),
                                   p1, p2[static_cast<std::size_t>(color_step(colors, x, y, x, from))],
                                   volume.count, paths.at(path, here), volume.sums_at(x, y));
        }
    }
}

}  // namespace

void aggregate(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
               const step::PathPenalties& penalties, MatchingVolume& volume, ThreadPool& pool) {
    const int width = left.width();
    const auto p1 = static_cast<Cost>(penalties.p1);
    PenaltyTable large_step;
    for (int i = 0; i < 256; ++i)
        large_step[static_cast<std::size_t>(i)] = step::large_step_penalty(penalties, i);
    const ColorView colors = view_of(left);

    pool.run([&](int thread) {
        CostRows cost_rows(left, right, range);
        PathCosts paths(1, range.count);
        std::vector<Cost> p2(static_cast<std::size_t>(width) + 1);
        const auto row = [&](int share) {
            return volume.first_row +
                   static_cast<int>(pool.share(static_cast<std::size_t>(volume.rows), share));
        };
        for (int y = row(thread); y < row(thread + 1); ++y) {
            cost_rows.compute(y, volume.costs_at(0, y));
            for (int x = 1; x < width; ++x)
                p2[static_cast<std::size_t>(x)] =
                    large_step[static_cast<std::size_t>(color_step(colors, x, y, x - 1, y))];
            paths_along_row(volume.costs_at(0, y), p2.data(), p1, width, range.count, paths,
                            volume.sums_at(0, y));
        }
    });
    // As many columns at once as their paths' costs stay in the first-level cache.
    const int strip = std::max(8, 2048 / range.count);
    pool.parallel_for_chunks(
        static_cast<std::size_t>((width + strip - 1) / strip), [&](std::size_t first, std::size_t end) {
            PathCosts paths(strip, range.count);
            for (std::size_t i = first; i < end; ++i) {
                const int x = static_cast<int>(i) * strip;
                const Columns columns{x, std::min(width, x + strip)};
                for (const Direction direction : {Direction::down, Direction::up})
                    paths_along_columns(colors, large_step, p1, columns, direction, paths, volume);
            }
        });
}

}  // namespace hexrelief
