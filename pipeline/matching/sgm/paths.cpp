#include "pipeline/matching/sgm/paths.h"

#include <algorithm>
#include <array>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/sgm/costs.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief::matching {
namespace {

using Cost = std::uint16_t;
using PenaltyTable = std::array<Cost, 256>;  // penalties of large steps, indexed by the colour step

using SmallStep = step::SmallStep<Cost>;

// The costs of several paths at their previous and current pixels, increased by p1 (see path_step.h),
// side by side: one entry per disparity of the range, kNoPath outside the pixel's window, so that windows
// may differ between pixels.
class PathCosts {
  public:
    PathCosts(int paths, int count)
        : paths_(static_cast<std::size_t>(paths)),
          stride_(static_cast<std::size_t>(std::max(count + step::kRunAlignment, kWholeRange) + 2 * kPad)),
          values_(2 * paths_ * stride_, step::kNoPath),
          least_(2 * paths_),
          windows_(2 * paths_, kWholeWindow) {}

    // Moves to a pixel with this window, whose costs are not set yet.
    template <int kRun>
    void enter(int path, int parity, SearchWindow window) {
        Cost* const costs = at(path, parity);
        SearchWindow& before = windows_[index(path, parity)];
        for (const int first : {before.far_run, before.near_run})
            std::fill_n(costs + first, kRun, step::kNoPath);
        before = window;
    }
    // Begins a path: its costs before the first pixel are 0.
    template <int kRun>
    void begin(int path, int parity, SearchWindow window, Cost p1) {
        enter<kRun>(path, parity, window);
        for (const int first : {window.far_run, window.near_run})
            std::fill_n(at(path, parity) + first, kRun, p1);
        least(path, parity) = p1;
    }
    // Sets a path's costs; `costs` holds both runs.
    template <int kRun>
    void load(int path, int parity, SearchWindow window, const Cost* costs) {
        enter<kRun>(path, parity, window);
        std::copy_n(costs, kRun, at(path, parity) + window.far_run);
        std::copy_n(costs + kRun, kRun, at(path, parity) + window.near_run);
        least(path, parity) = *std::min_element(costs, costs + 2 * kRun);
    }
    template <int kRun>
    void store(int path, int parity, Cost* costs) {
        const SearchWindow window = windows_[index(path, parity)];
        std::copy_n(at(path, parity) + window.far_run, kRun, costs);
        std::copy_n(at(path, parity) + window.near_run, kRun, costs + kRun);
    }
    // Returns the cost of disparity 0. One entry beyond the range may be read on both sides.
    Cost* at(int path, int parity) { return values_.data() + index(path, parity) * stride_ + kPad; }
    Cost& least(int path, int parity) { return least_[index(path, parity)]; }

  private:
    static constexpr int kPad = 32;
    std::size_t index(int path, int parity) const { return parity * paths_ + path; }

    std::size_t paths_;
    std::size_t stride_;
    std::vector<Cost> values_, least_;
    std::vector<SearchWindow> windows_;
};

enum class Sums { none, set, add };

// Advances one run of a path from the previous pixel's costs to the current ones, which are put into the
// sums. Returns the least of them.
template <int kRun, Sums kSums>
HEXRELIEF_INLINED Cost advance_run(const Cost* __restrict before, const step::PathSteps<Cost>& steps,
                                   const std::uint8_t* __restrict costs, Cost* __restrict here,
                                   Cost* __restrict sums) {
    const Cost p1 = steps.small_step.p1;
    Cost best = step::kNoPath;
    for (int d = 0; d < kRun; ++d) {
        const Cost cost = step::path_cost<Cost>(before[d], before[d - 1], before[d + 1], steps, costs[d]);
        here[d] = cost;
        if (kSums != Sums::none)
            sums[d] = static_cast<Cost>((kSums == Sums::set ? cost : sums[d] + cost) - p1);
        best = best < cost ? best : cost;
    }
    return best;
}

template <int kRun, Sums kSums>
HEXRELIEF_INLINED void advance(PathCosts& paths, int path, int here, SearchWindow window,
                               const std::uint8_t* costs, const SmallStep& small_step, Cost p2, Cost* sums) {
    const int before = here ^ 1, far_run = window.far_run, near_run = window.near_run;
    paths.enter<kRun>(path, here, window);
    const auto steps = step::path_steps(paths.least(path, before), small_step, p2);
    const Cost* from = paths.at(path, before);
    Cost* to = paths.at(path, here);
    const Cost best_far = advance_run<kRun, kSums>(from + far_run, steps, costs, to + far_run, sums);
    const Cost best_near =
        advance_run<kRun, kSums>(from + near_run, steps, costs + kRun, to + near_run, sums + kRun);
    paths.least(path, here) = std::min(best_far, best_near);
}

// A row of the volume. p2[x] is the penalty of a large step between pixels x - 1 and x.
struct PathRowView {
    const std::uint8_t* costs;
    const SearchWindow* windows;
    const Cost* p2;
    SmallStep small_step;
    int width;
};
template <int kRun>
HEXRELIEF_INLINED void follow_row(const PathRowView& row, PathCosts& paths, Cost* sums) {
    const auto at = [](int x) { return static_cast<std::size_t>(x) * 2 * kRun; };
    const int width = row.width;
    paths.begin<kRun>(0, 1, row.windows[0], row.small_step.p1);
    for (int x = 0; x < width; ++x)
        advance<kRun, Sums::set>(paths, 0, x & 1, row.windows[x], row.costs + at(x), row.small_step,
                                 row.p2[x], sums + at(x));
    paths.begin<kRun>(0, 1, row.windows[width - 1], row.small_step.p1);
    for (int i = 0; i < width; ++i) {
        const int x = width - 1 - i;
        advance<kRun, Sums::add>(paths, 0, i & 1, row.windows[x], row.costs + at(x), row.small_step,
                                 row.p2[x + 1], sums + at(x));
    }
}
HEXRELIEF_SMALL_VECTORS void paths_along_row(const PathRowView& row, bool searched_wholly, PathCosts& paths,
                                             Cost* sums) {
    if (searched_wholly)
        follow_row<kLongRun>(row, paths, sums);
    else
        follow_row<kShortRun>(row, paths, sums);
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
// A strip of columns. before: the paths' costs at the row that they come from. last: receives those at the
// last row of the volume; may be null.
struct Columns {
    int first, end;
    Direction direction;
    PathRow before;
    Cost* last;
};

template <int kRun, Sums kSums>
HEXRELIEF_INLINED void follow_columns(const MatchingInput& input, const ColorView& colors,
                                      const PenaltyTable& p2, const Columns& columns, PathCosts& paths,
                                      MatchingVolume& volume) {
    const auto small_step = step::small_step<Cost>(input.penalties.p1);
    const auto at = [](int x) { return static_cast<std::size_t>(x) * 2 * kRun; };
    const bool down = columns.direction == Direction::down;
    const int first = down ? volume.first_row : volume.first_row + volume.rows - 1, onward = down ? 1 : -1;
    for (int x = columns.first; x < columns.end; ++x)
        paths.load<kRun>(x - columns.first, 1, input.windows.at(x, columns.before.y),
                         columns.before.costs + at(x));
    for (int i = 0; i < volume.rows; ++i) {
        const int y = first + i * onward;
        for (int x = columns.first; x < columns.end; ++x)
            advance<kRun, kSums>(
                paths, x - columns.first, i & 1, input.windows.at(x, y), volume.costs_at(x, y), small_step,
                p2[static_cast<std::size_t>(color_step(colors, x, y, x, y - onward))], volume.sums_at(x, y));
    }
    if (!columns.last) return;
    for (int x = columns.first; x < columns.end; ++x)
        paths.store<kRun>(x - columns.first, (volume.rows - 1) & 1, columns.last + at(x));
}

HEXRELIEF_SMALL_VECTORS void paths_along_columns(const MatchingInput& input, const ColorView& colors,
                                                 const PenaltyTable& p2, const Columns& columns, Sums sums,
                                                 PathCosts& paths, MatchingVolume& volume) {
    const bool adds = sums == Sums::add;
    if (is_searched_wholly(input.range))
        adds ? follow_columns<kLongRun, Sums::add>(input, colors, p2, columns, paths, volume)
             : follow_columns<kLongRun, Sums::none>(input, colors, p2, columns, paths, volume);
    else
        adds ? follow_columns<kShortRun, Sums::add>(input, colors, p2, columns, paths, volume)
             : follow_columns<kShortRun, Sums::none>(input, colors, p2, columns, paths, volume);
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
        pool.run_chunks<1>(static_cast<std::size_t>(volume.rows), thread, counters,
                           [&](std::size_t row) { body(scratch, volume.first_row + static_cast<int>(row)); });
    });
}

// Runs body(paths, first, end) for strips of columns that are narrow enough for their paths' costs to stay
// in the first-level cache.
template <typename Body>
void for_each_strip(const MatchingVolume& volume, int count, ThreadPool& pool, const Body& body) {
    constexpr int strip = 32;
    ThreadPool::ChunkCounters counters(pool.size());
    pool.run([&](int thread) {
        PathCosts paths(strip, count);
        pool.run_chunks<1>(static_cast<std::size_t>((volume.width + strip - 1) / strip), thread, counters,
                           [&](std::size_t i) {
                               const int x = static_cast<int>(i) * strip;
                               body(paths, x, std::min(volume.width, x + strip));
                           });
    });
}

}  // namespace

PathRows::PathRows(int rows, std::size_t row_entries)
    : row_entries_(row_entries), costs_(row_entries_ * rows) {
    for (int i = 0; i < rows; ++i) rows_.push_back({costs_.data() + i * row_entries_, 0});
}

void PathRows::begin(int index, int y, const step::PathPenalties& penalties) {
    row(index).y = y;
    std::fill_n(row(index).costs, row_entries_, static_cast<Cost>(penalties.p1));
}

void aggregate(const MatchingInput& input, const PathRow& above, PathRow& below, MatchingVolume& volume,
               ThreadPool& pool) {
    const PenaltyTable large_step = large_steps(input.penalties);
    const ColorView colors = view_of(input.left);
    struct RowScratch {
        CostRows costs;
        PathCosts paths;
        std::vector<Cost> p2;
    };
    const auto scratch = [&] {
        return RowScratch{CostRows(input.left, input.right, input.range, input.windows),
                          PathCosts(1, input.range.count),
                          std::vector<Cost>(static_cast<std::size_t>(volume.width) + 1)};
    };
    for_each_row_of(volume, pool, scratch, [&](RowScratch& row, int y) {
        row.costs.compute(y, volume.costs_at(0, y));
        for (int x = 1; x < volume.width; ++x)
            row.p2[static_cast<std::size_t>(x)] =
                large_step[static_cast<std::size_t>(color_step(colors, x, y, x - 1, y))];
        paths_along_row({volume.costs_at(0, y), input.windows.row(y), row.p2.data(),
                         step::small_step<Cost>(input.penalties.p1), volume.width},
                        is_searched_wholly(input.range), row.paths, volume.sums_at(0, y));
    });
    for_each_strip(volume, input.range.count, pool, [&](PathCosts& paths, int first, int end) {
        paths_along_columns(input, colors, large_step, {first, end, Direction::down, above, nullptr},
                            Sums::add, paths, volume);
        paths_along_columns(input, colors, large_step, {first, end, Direction::up, below, below.costs},
                            Sums::add, paths, volume);
    });
    below.y = volume.first_row;
}

void descend(const MatchingInput& input, const PathRow& above, PathRow& last, MatchingVolume& volume,
             ThreadPool& pool) {
    const PenaltyTable large_step = large_steps(input.penalties);
    const ColorView colors = view_of(input.left);
    for_each_row_of(
        volume, pool, [&] { return CostRows(input.left, input.right, input.range, input.windows); },
        [&](CostRows& costs, int y) { costs.compute(y, volume.costs_at(0, y)); });
    for_each_strip(volume, input.range.count, pool, [&](PathCosts& paths, int first, int end) {
        paths_along_columns(input, colors, large_step, {first, end, Direction::down, above, last.costs},
                            Sums::none, paths, volume);
    });
    last.y = volume.first_row + volume.rows - 1;
}

}  // namespace hexrelief::matching
