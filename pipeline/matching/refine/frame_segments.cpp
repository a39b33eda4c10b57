#include "pipeline/matching/refine/frame_segments.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/matching/common/raster.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/frame_segment_step.h"

namespace hexrelief {
namespace {

constexpr int kCells = 150;
constexpr int kLevel = 16;                // colours and their steps are in 1/16 level
constexpr int kSteps = 2 * 256 * kLevel;  // more than the distance of any two colours
// A segment of n cells takes a step that is larger than all within it by so many levels / n.
constexpr int kEase = 150;
constexpr int kSmall = 120;      // segments of a smaller part of all cells are joined to their neighbours
constexpr int kFewMatches = 20;  // one for so many cells without

// So many columns of cells count, if they are as many and a quarter more.
int with_margin(int columns) {
    return columns * 5 / 4 + 1;
}

// As far as filling leads beyond the right picture's left edge.
int columns_beyond_frame(const CellGrid& grid, int min_px, const std::vector<std::int16_t>& filled) {
    int columns = 0;
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
        const int column = static_cast<int>(cell) % grid.columns;
        const int x = step::middle_of_cell(column, grid.cell_px);
        if (filled[cell] >= 0 && step::beyond_left_edge(x, min_px, filled[cell]))
            columns = std::max(columns, column + 1);
    }
    return columns;
}

// The mean of each cell's pixels and of those around it, channel by channel.
std::vector<std::int16_t> mean_colors(const Image& image, const CellGrid& grid) {
    const int across = grid.cell_px + 2;
    const long long pixels = static_cast<long long>(across) * across;
    const int used = std::min(image.width, grid.columns * grid.cell_px + 1);
    std::vector<int> of_columns(static_cast<std::size_t>(used) * image.channels);  // sums of a row of cells
    std::vector<std::int16_t> means;
    for (int row = 0; row < grid.rows; ++row) {
        std::fill(of_columns.begin(), of_columns.end(), 0);
        for (int j = 0; j < across; ++j) {
            const int y = std::clamp(row * grid.cell_px - 1 + j, 0, image.height - 1);
            const std::uint8_t* of_row = image.at(0, y);
            for (std::size_t k = 0; k < of_columns.size(); ++k) of_columns[k] += of_row[k];
        }
        for (int column = 0; column < grid.columns; ++column)
            for (int c = 0; c < image.channels; ++c) {
                long long sum = 0;
                for (int i = 0; i < across; ++i) {
                    const int x = std::clamp(column * grid.cell_px - 1 + i, 0, image.width - 1);
                    sum += of_columns[x * image.channels + c];
                }
                means.push_back(static_cast<std::int16_t>((kLevel * sum + pixels / 2) / pixels));
            }
    }
    return means;
}

// Of all neighbouring cells.
std::vector<FrameEdge> edges_between(const Image& image, const CellGrid& grid) {
    const std::vector<std::int16_t> colors = mean_colors(image, grid);
    const auto step = [&](int a, int b) {
        int sum = 0;
        for (int c = 0; c < image.channels; ++c) {
            const int difference = colors[a * image.channels + c] - colors[b * image.channels + c];
            sum += difference * difference;
        }
        return static_cast<int>(std::sqrt(static_cast<double>(sum)));
    };
    std::vector<FrameEdge> edges;
    edges.reserve(4 * grid.size());
    for (int cell = 0; cell < static_cast<int>(grid.size()); ++cell) {
        const int column = cell % grid.columns;
        const bool last_row = cell / grid.columns + 1 == grid.rows;
        const auto add = [&](int other) { edges.push_back({cell, other, step(cell, other)}); };
        if (column + 1 < grid.columns) add(cell + 1);
        if (last_row) continue;
        if (column > 0) add(cell + grid.columns - 1);
        add(cell + grid.columns);
        if (column + 1 < grid.columns) add(cell + grid.columns + 1);
    }
    return edges;
}

// Counted, which takes a tenth of the time of comparing.
std::vector<FrameEdge> sorted_by_step(const std::vector<FrameEdge>& edges) {
    std::vector<int> places(kSteps + 1, 0);
    for (const FrameEdge& edge : edges) ++places[edge.step + 1];
    std::partial_sum(places.begin(), places.end(), places.begin());
    std::vector<FrameEdge> sorted(edges.size());
    for (const FrameEdge& edge : edges) sorted[places[edge.step]++] = edge;
    return sorted;
}

// Disjoint sets of cells.
class Segments {
  public:
    explicit Segments(std::size_t cells) : parents_(cells), sizes_(cells, 1), largest_steps_(cells, 0) {
        std::iota(parents_.begin(), parents_.end(), 0);
    }
    int of(int cell) {
        while (parents_[cell] != cell) cell = parents_[cell] = parents_[parents_[cell]];
        return cell;
    }
    // Each for all edges, from the least step to the largest.
    void join_alike(const FrameEdge& edge) {
        const int a = of(edge.a), b = of(edge.b);
        if (a == b || !takes(a, edge.step) || !takes(b, edge.step)) return;
        join(a, b);
        largest_steps_[a] = edge.step;
    }
    void join_small(const FrameEdge& edge, int least_cells) {
        const int a = of(edge.a), b = of(edge.b);
        if (a != b && std::min(sizes_[a], sizes_[b]) < least_cells) join(a, b);
    }

  private:
    bool takes(int segment, int step) const {
        const long long more = step - largest_steps_[segment];
        return more * sizes_[segment] <= kEase * kLevel;
    }
    void join(int a, int b) {
        parents_[b] = a;
        sizes_[a] += sizes_[b];
    }

    std::vector<int> parents_, sizes_, largest_steps_;
};

// Of a segment: the disparities of its unmatched cells, and how many were matched. Unknown if it is no
// thing.
std::int16_t least_of(std::vector<std::int16_t>& unmatched, int matched) {
    const auto count = static_cast<int>(unmatched.size());
    if (count == 0 || matched * kFewMatches > count) return kUnknown16;
    const auto quartile = unmatched.begin() + (count - 1) * 3 / 4;
    std::nth_element(unmatched.begin(), quartile, unmatched.end());
    return *quartile;
}

}  // namespace

CellGrid cell_grid(int width, int height) {
    const int cell_px = std::max(1, (std::max(width, height) + kCells / 2) / kCells);
    return {cell_px, width / cell_px, height / cell_px};
}

FrameEdges find_frame_edges(const Image& left, int most_px) {
    FrameEdges result{cell_grid(left.width, left.height), {}, {}};
    result.frame = result.whole;
    const int columns = std::max(0, most_px) / result.whole.cell_px + 1;
    result.frame.columns = std::min(result.whole.columns, with_margin(columns));
    result.sorted = sorted_by_step(edges_between(left, result.frame));
    return result;
}

std::vector<std::int16_t> least_disparities(const FrameEdges& edges, int min_px,
                                            const std::vector<std::int16_t>& filled) {
    const CellGrid &whole = edges.whole, &frame = edges.frame;
    const int columns = std::min(frame.columns, with_margin(columns_beyond_frame(whole, min_px, filled)));
    const int cells = columns * frame.rows;
    std::vector<char> counts(frame.size());
    std::vector<std::size_t> in_whole(frame.size());
    for (std::size_t cell = 0; cell < frame.size(); ++cell) {
        const std::size_t column = cell % frame.columns;
        counts[cell] = column < static_cast<std::size_t>(columns);
        in_whole[cell] = cell / frame.columns * whole.columns + column;
    }
    Segments segments(frame.size());
    for (const FrameEdge& edge : edges.sorted)
        if (counts[edge.a] && counts[edge.b]) segments.join_alike(edge);
    for (const FrameEdge& edge : edges.sorted)
        if (counts[edge.a] && counts[edge.b]) segments.join_small(edge, cells / kSmall);

    std::vector<std::vector<std::int16_t>> unmatched(frame.size());  // by segment
    std::vector<int> matched(frame.size(), 0);
    for (std::size_t cell = 0; cell < frame.size(); ++cell) {
        if (!counts[cell]) continue;
        const int segment = segments.of(static_cast<int>(cell));
        const std::int16_t disparity = filled[in_whole[cell]];
        if (disparity == kUnknown16)
            ++matched[segment];
        else
            unmatched[segment].push_back(disparity);
    }
    std::vector<std::int16_t> least(frame.size()), result(whole.size(), kUnknown16);
    for (std::size_t i = 0; i < frame.size(); ++i) least[i] = least_of(unmatched[i], matched[i]);
    for (std::size_t cell = 0; cell < frame.size(); ++cell)
        if (counts[cell]) result[in_whole[cell]] = least[segments.of(static_cast<int>(cell))];
    return result;
}

}  // namespace hexrelief
