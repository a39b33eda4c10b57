#include "exporters/compression/quantisation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <compare>
#include <numeric>
#include <span>
#include <utility>

#include "pipeline/data/bounds.h"
#include "pipeline/data/counting_sort.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"

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
        std::ranges::sort(halves);
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
    std::ranges::nth_element(wanted, middle);
    return *middle;
}

constexpr double kSafety = 0.995;
constexpr double kFloatRounding = 1.0 / (1 << 23);  // two roundings of half a unit in the last place
constexpr double kMostCells = (1 << 24) - 1;
// A third sweep still saves 0.1 % of the bytes, a fourth nothing.
constexpr int kSweeps = 3;

[[noreturn]] void refuse() {
    throw Error(ErrorKind::output,
                "export.tolerance_px is too small for this mesh: its vertices would need more than 24 bits a "
                "coordinate; raise it, or write a format other than .drc with export.compression: none");
}

void check_cells(double low, double high, double step) {
    if (!((high - low) / step + 1 <= kMostCells)) refuse();
}

// Returns the cells within an interval. If rounding leaves it without a cell, returns the cell
// nearest to its middle.
CellRange cells_in(double low, double high, double step) {
    CellRange out{static_cast<std::int32_t>(std::ceil(low / step)),
                  static_cast<std::int32_t>(std::floor(high / step))};
    if (out.low > out.high)
        out.low = out.high = static_cast<std::int32_t>(std::lround((low + high) / 2 / step));
    return out;
}

// The extent of the vertices, in metres from the camera.
struct Extent {
    double near = INFINITY;    // least depth
    double far = 0, wide = 0;  // largest depth, and largest |x| or |y|, that the grid has to reach
};

// Measures the extent; `tolerance` is in px of disparity.
Extent extent_of(const SurfaceMesh& mesh, double focal_baseline, double tolerance) {
    Extent extent;
    for (const Vec3f& p : mesh.positions) {
        const double depth = -static_cast<double>(p.z);
        extent.near = std::min(extent.near, depth);
        // The grid need not reach the vertex's own depth: a depth that changes its disparity by half the
        // tolerance is enough, which is much nearer if the disparity is next to 0.
        const double enough = focal_baseline / (focal_baseline / depth + tolerance / 2);
        extent.far = std::max(extent.far, enough);
        extent.wide = std::max(
            {extent.wide, std::abs(double(p.x)) / depth * enough, std::abs(double(p.y)) / depth * enough});
    }
    return extent;
}

struct Camera {
    double focal, focal_baseline, tolerance;
};

Camera camera_of(const Calibration& calibration, const Extent& extent, double tolerance_px, GridShape shape) {
    const double focal = calibration.focal_px;
    double tolerance = tolerance_px * kSafety;
    if (shape == GridShape::cubic) {
        // Decoders add the origin in 32-bit floats, which moves the nearest vertex furthest in the image.
        tolerance -= kFloatRounding * std::max(extent.far, extent.wide) * focal / extent.near *
                     std::max(1.0, calibration.baseline_m / extent.near);
        if (!(tolerance > tolerance_px / 2)) refuse();
    }
    return {focal, focal * calibration.baseline_m, tolerance};
}

// The steps in metres between two cells of x or y, and of depth.
struct Steps {
    double lateral, depth;
    std::int32_t stride = 1;  // cells of the grid between two depths
};

Steps steps_of(const Extent& extent, const Camera& camera, GridShape shape) {
    // A step of depth changes the nearest vertex's disparity most, so its step h is such that fB / (near - h)
    // - fB / near is the tolerance.
    const double near = extent.near;
    const double h = camera.tolerance * near * near / (camera.focal_baseline + camera.tolerance * near);
    Steps steps{2 * camera.tolerance * (near - h) / camera.focal, 2 * h};
    if (shape == GridShape::cubic) {
        const double step = std::min(steps.lateral, steps.depth);
        check_cells(0, std::max(extent.far, 2 * extent.wide), step);
        steps.stride = static_cast<std::int32_t>(steps.depth / step);
        return {step, steps.stride * step, steps.stride};
    }
    check_cells(0, 2 * extent.wide, steps.lateral);
    check_cells(0, extent.far, steps.depth);
    return steps;
}

// Returns the cells that each vertex's depth may have, counted from the camera and limited to `all`, the
// cells between the nearest and the farthest vertex.
std::vector<CellRange> depth_ranges(const SurfaceMesh& mesh, const Camera& camera, double step,
                                    const CellRange& all) {
    std::vector<CellRange> ranges;
    ranges.reserve(mesh.positions.size());
    for (const Vec3f& p : mesh.positions) {
        const double disparity = camera.focal_baseline / -p.z;
        const double near = camera.focal_baseline / (disparity + camera.tolerance);
        const double least = disparity - camera.tolerance;
        const double far =
            least > 0 ? std::min(camera.focal_baseline / least, all.high * step) : all.high * step;
        CellRange range = cells_in(near, far, step);
        range.low = std::clamp(range.low, all.low, all.high);
        range.high = std::clamp(range.high, range.low, all.high);
        ranges.push_back(range);
    }
    return ranges;
}

// Stores the cells of one axis in the grid, counted from the smallest.
void set_axis(Grid<3>& grid, int axis, const std::vector<std::int32_t>& cells, std::int32_t stride) {
    const auto [least, most] = std::minmax_element(cells.begin(), cells.end());
    grid.origin[axis] = grid.step[axis] * stride * *least;
    grid.largest[axis] = (*most - *least) * stride;
    for (std::size_t i = 0; i < cells.size(); ++i) grid.cells[i][axis] = (cells[i] - *least) * stride;
}

}  // namespace

GridNeighbours::GridNeighbours(const std::vector<Triangle>& triangles, std::size_t vertex_count)
    : starts_(vertex_count + 1, 0) {
    const std::vector<InnerEdge> edges = inner_edges(triangles, vertex_count);
    for (const InnerEdge& e : edges)
        for (const std::uint32_t v : {e.a, e.b, e.c, e.d}) ++starts_[v + 1];
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
    for (int sweep = 0; sweep < sweeps; ++sweep)
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
    return cells;
}

template <int N>
int Grid<N>::bits() const {
    const std::int32_t most = *std::ranges::max_element(largest);
    return std::max(1, static_cast<int>(std::bit_width(static_cast<std::uint32_t>(most))));
}
template int Grid<2>::bits() const;
template int Grid<3>::bits() const;

// Depths are chosen first. x and y are then those at which the vertex's own ray meets the chosen depth, so
// that an error in depth does not shift the vertex in the image; rounding each coordinate by itself needs a
// finer grid for the same error.
Grid<3> quantise_positions(const SurfaceMesh& mesh, const Calibration& calibration, double tolerance_px,
                           GridShape shape, int threads) {
    const Extent extent =
        extent_of(mesh, calibration.focal_px * calibration.baseline_m, tolerance_px * kSafety);
    const Camera camera = camera_of(calibration, extent, tolerance_px, shape);
    const Steps steps = steps_of(extent, camera, shape);
    Grid<3> grid;
    grid.step = {steps.lateral, steps.lateral, shape == GridShape::cubic ? steps.lateral : steps.depth};
    grid.cells.resize(mesh.positions.size());
    const GridNeighbours neighbours(mesh.triangles, mesh.positions.size());

    const CellRange depths{static_cast<std::int32_t>(std::floor(extent.near / steps.depth)),
                           static_cast<std::int32_t>(std::ceil(extent.far / steps.depth))};
    std::vector<std::int32_t> cells =
        neighbours.smooth(depth_ranges(mesh, camera, steps.depth, depths), kSweeps);
    std::vector<double> chosen(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        chosen[i] = cells[i] * steps.depth;
        cells[i] = -cells[i];  // glTF's camera looks along -Z
    }
    set_axis(grid, 2, cells, steps.stride);
    const auto lateral_cells = [&](int axis) {
        std::vector<CellRange> ranges(chosen.size());
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            const Vec3f& p = mesh.positions[i];
            const double slope = (axis == 0 ? p.x : p.y) / -static_cast<double>(p.z);
            const double slack = camera.tolerance / camera.focal;
            ranges[i] = cells_in((slope - slack) * chosen[i], (slope + slack) * chosen[i], steps.lateral);
        }
        return neighbours.smooth(ranges, kSweeps);
    };
    auto x_cells = start_work(threads, [&] { return lateral_cells(0); });
    set_axis(grid, 1, lateral_cells(1), 1);
    set_axis(grid, 0, x_cells.get(), 1);
    if (grid.bits() > 24) refuse();
    return grid;
}

Grid<3> exact_grid(const std::vector<Vec3f>& positions, double step) {
    const Bounds bounds = bounds_of(positions);
    Grid<3> grid{{bounds.low.x, bounds.low.y, bounds.low.z}, {step, step, step}, {}, {}};
    grid.cells.reserve(positions.size());
    for (const Vec3f& p : positions) {
        const std::array<double, 3> at = {p.x, p.y, p.z};
        std::array<std::int32_t, 3>& cell = grid.cells.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            cell[k] = static_cast<std::int32_t>((at[k] - grid.origin[k]) / step);
            grid.largest[k] = std::max(grid.largest[k], cell[k]);
        }
    }
    return grid;
}

Grid<2> quantise_texcoords(const std::vector<Vec2f>& texcoords, int width, int height, double tolerance_px,
                           GridShape shape) {
    const double tolerance = tolerance_px * kSafety;
    Grid<2> grid;
    grid.step = {2 * tolerance / width, 2 * tolerance / height};
    if (shape == GridShape::cubic) grid.step[0] = grid.step[1] = std::min(grid.step[0], grid.step[1]);
    check_cells(0, 1, grid.step[0]);
    check_cells(0, 1, grid.step[1]);
    grid.cells.reserve(texcoords.size());
    for (const Vec2f& t : texcoords) {
        const auto cell = [&](float value, int axis) {
            return static_cast<std::int32_t>(std::lround(value / grid.step[axis]));
        };
        grid.cells.push_back({cell(t.x, 0), cell(t.y, 1)});
        for (int axis = 0; axis < 2; ++axis)
            grid.largest[axis] = std::max(grid.largest[axis], grid.cells.back()[axis]);
    }
    return grid;
}

}  // namespace hexrelief::exporters
