#include "exporters/compression/grid_smoothing.h"

#include <algorithm>
#include <compare>
#include <numeric>
#include <span>
#include <utility>

#include "pipeline/data/counting_sort.h"

namespace hexrelief::exporters {
namespace {

struct InnerEdge {
    std::uint32_t a, b, c, d;
};

// An edge seen from one of its triangles, without its vertex of lower index.
struct HalfEdge {
    std::uint32_t high, tip;
    auto operator<=>(const HalfEdge&) const = default;
};

std::vector<InnerEdge> inner_edges(const std::vector<Triangle>& triangles, std::size_t vertex_count) {
    const auto half = [&](std::uint32_t index) {
        const Triangle& t = triangles[index / 3];
        const std::uint32_t i = index % 3, a = t[i], b = t[(i + 1) % 3];
        return std::pair{std::min(a, b), HalfEdge{std::max(a, b), t[(i + 2) % 3]}};
    };
    const Buckets halves_of_low = sort_into(vertex_count, [&](const auto& put) {
        for (std::uint32_t index = 0; index < 3 * triangles.size(); ++index) put(half(index).first, index);
    });
    std::vector<InnerEdge> edges;
    edges.reserve(3 * triangles.size() / 2);
    std::vector<HalfEdge> halves;
    for (std::uint32_t low = 0; low < vertex_count; ++low) {
        halves.clear();
        for (const std::uint32_t index : halves_of_low[low]) halves.push_back(half(index).second);
        std::sort(halves.begin(), halves.end());
        for (std::size_t i = 0; i + 1 < halves.size(); ++i)
            if (halves[i].high == halves[i + 1].high)
                edges.push_back({low, halves[i].high, halves[i].tip, halves[i + 1].tip});
    }
    return edges;
}

// Returns the cell in the range that minimises the sum of distances to `wanted`, and is nearest to `own` if
// there are several: the sum is constant between the two middle values. Mostly this is `own` or an end of the
// range, which counting detects.
std::int32_t best_cell(std::int32_t own, const CellRange& range, std::span<std::int32_t> wanted) {
    std::size_t below = 0, above = 0, up_to_low = 0, from_high = 0;
    for (const std::int32_t cell : wanted) {
        below += cell < own;
        above += cell > own;
        up_to_low += cell <= range.low;
        from_high += cell >= range.high;
    }
    const std::size_t half = wanted.size() / 2;
    if (below <= half && above <= half) return own;
    if (up_to_low > half) return range.low;
    if (from_high > half) return range.high;
    const auto middle =
        wanted.begin() + static_cast<std::ptrdiff_t>(below > half ? half : (wanted.size() - 1) / 2);
    std::nth_element(wanted.begin(), middle, wanted.end());
    return *middle;
}

}  // namespace

GridNeighbours::GridNeighbours(const std::vector<Triangle>& triangles, std::size_t vertex_count)
    : starts_(vertex_count + 1, 0) {
    const std::vector<InnerEdge> edges = inner_edges(triangles, vertex_count);
    for (const InnerEdge& e : edges) {
        for (const std::uint32_t v : {e.a, e.b, e.c, e.d}) ++starts_[v + 1];
    }
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    terms_.resize(4 * edges.size());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (const InnerEdge& e : edges) {
        terms_[next[e.a]++] = {e.c, e.d, e.b};
        terms_[next[e.b]++] = {e.c, e.d, e.a};
        terms_[next[e.c]++] = {e.a, e.b, e.d};
        terms_[next[e.d]++] = {e.a, e.b, e.c};
    }
}

std::vector<std::int32_t> GridNeighbours::smooth(const std::vector<CellRange>& ranges, int sweeps) const {
    std::vector<std::int32_t> cells(ranges.size()), wanted;
    for (std::size_t v = 0; v < cells.size(); ++v)
        wanted.resize(std::max<std::size_t>(wanted.size(), starts_[v + 1] - starts_[v]));
    for (std::size_t v = 0; v < cells.size(); ++v)
        cells[v] = static_cast<std::int32_t>((std::int64_t{ranges[v].low} + ranges[v].high) / 2);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (std::size_t v = 0; v < cells.size(); ++v) {
            const std::uint32_t begin = starts_[v], end = starts_[v + 1];
            if (ranges[v].low == ranges[v].high || begin == end) continue;
            const std::uint32_t count = end - begin;
            for (std::uint32_t i = 0; i < count; ++i) {
                const Term& t = terms_[begin + i];
                wanted[i] = cells[t.plus1] + cells[t.plus2] - cells[t.minus];
            }
            cells[v] = best_cell(cells[v], ranges[v], {wanted.data(), count});
        }
    }
    return cells;
}

}  // namespace hexrelief::exporters
