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
          stride_(static_cast<std::size_t>(count + 2 * kPad)),
          values_(2 * paths_ * stride_, step::kNoPath),
          least_(2 * paths_) {}

    // A path that begins costs nothing before.
    void begin(int path, int parity) {
        std::fill_n(at(path, parity), count_, Cost{0});
        least(path, parity) = 0;
    }
    void load(int path, int parity, const Cost* costs) {
        std::copy_n(costs, count_, at(path, parity));
        least(path, parity) = *std::min_element(costs, costs + count_);
    }
    void store(int path, int parity, Cost* costs) { std::copy_n(at(path, parity), count_, costs); }
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

enum class Sums { none, set, add };

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
        if (kSums != Sums::none) sums[d] = kSums == Sums::set ? cost : static_cast<Cost>(sums[d] + cost);
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
// before: the paths' costs at the row that they come from; last, if any: at the volume's last row for them.
struct Columns {
    int first, end;
    Direction direction;
    const Cost* before;
    Cost* last;
};

template <Sums kSums>
HEXRELIEF_INLINED void follow_columns(const ColorView& colors, const PenaltyTable& p2, Cost p1,
                                      const Columns& columns, PathCosts& paths, MatchingVolume& volume) {
    const auto at = [&](int x) { return static_cast<std::size_t>(x) * volume.count; };
    for (int x = columns.first; x < columns.end; ++x)
        paths.load(x - columns.first, 1, columns.before + at(x));
    for (int i = 0; i < volume.rows; ++i) {
        const bool down = columns.direction == Direction::down;
        const int y = volume.first_row + (down ? i : volume.rows - 1 - i), from = down ? y - 1 : y + 1;
        const int here = i & 1, before = here ^ 1;
        for (int x = columns.first; x < columns.end; ++x) {
            const int path = x - columns.first;
            paths.least(path, here) =
                advance<kSums>(paths.at(path, before), paths.least(path, before), volume.costs_at(x, y), p1,
                               p2[static_cast<std::size_t>(color_step(colors, x, y, x, from))], volume.count,
                               paths.at(path, here), volume.sums_at(x, y));
        }
    }
    if (!columns.last) return;
    for (int x = columns.first; x < columns.end; ++x)
        paths.store(x - columns.first, (volume.rows - 1) & 1, columns.last + at(x));
}

HEXRELIEF_SMALL_VECTORS void paths_along_columns(const ColorView& colors, const PenaltyTable& p2, Cost p1,
                                                 const Columns& columns, Sums sums, PathCosts& paths,
                                                 MatchingVolume& volume) {
    if (sums == Sums::none)
        follow_columns<Sums::none>(colors, p2, p1, columns, paths, volume);
    else
        follow_columns<Sums::add>(colors, p2, p1, columns, paths, volume);
}

PenaltyTable large_steps(const step::PathPenalties& penalties) {
    PenaltyTable table;
    for (int i = 0; i < 256; ++i) table[static_cast<std::size_t>(i)] = step::large_step_penalty(penalties, i);
    return table;
}

// Runs body(thread's scratch, y) for all rows of the volume.
template <typename Scratch, typename Body>
void for_each_row_of(const MatchingVolume& volume, ThreadPool& pool, const Scratch& scratch_of,
                     const Body& body) {
    ThreadPool::ChunkCounters counters(pool.size());
    pool.run([&](int thread) {
        auto scratch = scratch_of();
        pool.run_chunks<1>(
            static_cast<std::size_t>(volume.rows), thread, counters,
            [&](std::size_t row, std::size_t) { body(scratch, volume.first_row + static_cast<int>(row)); });
    });
}

// Runs body(paths, first, end) for strips of as many columns as their paths' costs stay in the first-level
// cache.
template <typename Body>
void for_each_strip(const MatchingVolume& volume, ThreadPool& pool, const Body& body) {
    const int strip = std::max(8, 2048 / volume.count);
    ThreadPool::ChunkCounters counters(pool.size());
    pool.run([&](int thread) {
        PathCosts paths(strip, volume.count);
        pool.run_chunks<1>(static_cast<std::size_t>((volume.width + strip - 1) / strip), thread, counters,
                           [&](std::size_t i, std::size_t) {
                               const int x = static_cast<int>(i) * strip;
                               body(paths, x, std::min(volume.width, x + strip));
                           });
    });
}

}  // namespace

PathRows::PathRows(int rows, int width, int count)
    : row_entries_(static_cast<std::size_t>(width) * count), costs_(row_entries_ * rows) {}

void PathRows::begin(int index) {
    std::fill_n(row(index), row_entries_, Cost{0});
}

void aggregate(const MatchingInput& input, const Cost* above, Cost* below, MatchingVolume& volume,
               ThreadPool& pool) {
    const auto p1 = static_cast<Cost>(input.penalties.p1);
    const PenaltyTable large_step = large_steps(input.penalties);
    const ColorView colors = view_of(input.left);
    struct RowScratch {
        CostRows costs;
        PathCosts paths;
        std::vector<Cost> p2;
    };
    const auto scratch = [&] {
        return RowScratch{CostRows(input.left, input.right, input.range), PathCosts(1, volume.count),
                          std::vector<Cost>(static_cast<std::size_t>(volume.width) + 1)};
    };
    for_each_row_of(volume, pool, scratch, [&](RowScratch& row, int y) {
        row.costs.compute(y, volume.costs_at(0, y));
        for (int x = 1; x < volume.width; ++x)
            row.p2[static_cast<std::size_t>(x)] =
                large_step[static_cast<std::size_t>(color_step(colors, x, y, x - 1, y))];
        paths_along_row(volume.costs_at(0, y), row.p2.data(), p1, volume.width, volume.count, row.paths,
                        volume.sums_at(0, y));
    });
    for_each_strip(volume, pool, [&](PathCosts& paths, int first, int end) {
        paths_along_columns(colors, large_step, p1, {first, end, Direction::down, above, nullptr}, Sums::add,
                            paths, volume);
        paths_along_columns(colors, large_step, p1, {first, end, Direction::up, below, below}, Sums::add,
                            paths, volume);
    });
}

void descend(const MatchingInput& input, const Cost* above, Cost* last, MatchingVolume& volume,
             ThreadPool& pool) {
    const PenaltyTable large_step = large_steps(input.penalties);
    const ColorView colors = view_of(input.left);
    for_each_row_of(
        volume, pool, [&] { return CostRows(input.left, input.right, input.range); },
        [&](CostRows& costs, int y) { costs.compute(y, volume.costs_at(0, y)); });
    for_each_strip(volume, pool, [&](PathCosts& paths, int first, int end) {
        paths_along_columns(colors, large_step, static_cast<Cost>(input.penalties.p1),
                            {first, end, Direction::down, above, last}, Sums::none, paths, volume);
    });
}

}  // namespace hexrelief
