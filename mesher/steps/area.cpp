#include "mesher/steps/area.h"

#include <algorithm>
#include <cmath>

#include "mesher/steps/plan.h"

namespace hexrelief {
namespace {

// Of the lattice's spacing in one direction over that in the other: triangles of 27 degrees before anything
// moves. More leaves less of a thin map's surroundings in the mesh, but its triangles no room for shape.
constexpr double kMostStretch = 2;

// Grows [first, end) evenly to `length` within [0, limit).
void grow(int& first, int& end, int length, int limit) {
    if (end - first >= length) return;
    first = std::clamp(first - (length - (end - first)) / 2, 0, limit - length);
    end = first + length;
}

}  // namespace

MeshArea mesh_area(const DensityMap& density, const MeshConfig& config) {
    const int width = density.width, height = density.height;
    const MeshArea whole{0, 0, width, height};
    if (config.border != MeshBorder::fit) return whole;
    const auto row = [&](int y) { return &density.values[static_cast<std::size_t>(y) * width]; };
    const auto empty = [&](int y) {
        return std::none_of(row(y), row(y) + width, [](float d) { return d > 0; });
    };
    int left = width, right = 0, top = 0, bottom = height;
    while (top < bottom && empty(top)) ++top;
    while (bottom > top && empty(bottom - 1)) --bottom;
    for (int y = top; y < bottom; ++y) {
        left = static_cast<int>(std::find_if(row(y), row(y) + left, [](float d) { return d > 0; }) - row(y));
        int last = width;
        while (last > right && !(row(y)[last - 1] > 0)) --last;
        right = last;
    }
    if (top == bottom) return whole;
    const step::Lattice lattice = lattice_size(width, height, config.spacing_px);
    const auto ceil_to = [](double length, int limit) {
        return std::min(static_cast<int>(std::ceil(length)), limit);
    };
    grow(left, right, std::min(lattice.columns, width), width);
    grow(top, bottom, std::min(lattice.rows, height), height);
    const double across = static_cast<double>(right - left) / lattice.columns,
                 down = static_cast<double>(bottom - top) / lattice.rows;
    grow(left, right, ceil_to(down / kMostStretch * lattice.columns, width), width);
    grow(top, bottom, ceil_to(across / kMostStretch * lattice.rows, height), height);
    return {left, top, right - left, bottom - top};
}

std::vector<float> density_within(const DensityMap& density, const MeshArea& area) {
    std::vector<float> values(static_cast<std::size_t>(area.width) * area.height);
    for (int y = 0; y < area.height; ++y) {
        const auto from =
            density.values.begin() + static_cast<std::ptrdiff_t>(area.y + y) * density.width + area.x;
        std::copy(from, from + area.width, values.begin() + static_cast<std::ptrdiff_t>(y) * area.width);
    }
    return values;
}

}  // namespace hexrelief
