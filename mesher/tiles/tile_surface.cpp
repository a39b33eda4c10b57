#include "mesher/tiles/tile_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace hexrelief::mesh_tiles {
namespace {

// The border of a tile as a closed polygon: between tiles the lattice's border line, which both share; at the
// map's border a line far beyond it.
class TileBorder {
  public:
    TileBorder(const LatticeTiling& tiling, int i, int j, const LatticeBlock& block) {
        const int left = tiling.column_of(i), right = tiling.column_of(i + 1), top = tiling.row_of(j),
                  bottom = tiling.row_of(j + 1);
        const auto add = [&](int column, int row) {
            Place p = block.at(column, row);
            if (column == 0) p.x = -kFar;
            if (row == 0) p.y = -kFar;
            if (column == tiling.columns() - 1) p.x = kFar;
            if (row == tiling.rows() - 1) p.y = kFar;
            if (column == left) left_ = std::max(left_, p.x);
            if (column == right) right_ = std::min(right_, p.x);
            if (row == top) top_ = std::max(top_, p.y);
            if (row == bottom) bottom_ = std::min(bottom_, p.y);
            corners_.push_back(p);
        };
        for (int column = left; column < right; ++column) add(column, top);
        for (int row = top; row < bottom; ++row) add(right, row);
        for (int column = right; column > left; --column) add(column, bottom);
        for (int row = bottom; row > top; --row) add(left, row);
        sort_into_rows();
    }

    // True if the centre of three places lies within the border. For a centre on the border this holds for
    // exactly one of the two tiles, because both compute the same numbers.
    bool holds(const Place& a, const Place& b, const Place& c) const {
        const std::int64_t x = std::int64_t{a.x} + b.x + c.x, y = std::int64_t{a.y} + b.y + c.y;
        // Most centres are beyond no vertex of any side.
        if (3 * left_ < x && x < 3 * right_ && 3 * top_ < y && y < 3 * bottom_) return true;
        bool within = false;
        for (const std::uint32_t k : rows_[row_of(y)]) within ^= passes_left_of(k, x, y);
        return within;
    }

  private:
    static constexpr std::int32_t kFar = 1 << 29;
    // 16 px, in thirds of Place's unit
    static constexpr std::int64_t kRow = std::int64_t{48} * kPlacesPerPixel;

    // Sorts the border's sides into rows, to find those that a line from a centre to the left may cross.
    void sort_into_rows() {
        first_ = std::numeric_limits<std::int64_t>::max();
        std::int64_t last = std::numeric_limits<std::int64_t>::min();
        for (const Place& p : corners_) {
            if (std::abs(p.y) == kFar) continue;
            first_ = std::min(first_, 3 * std::int64_t{p.y});
            last = std::max(last, 3 * std::int64_t{p.y});
        }
        rows_.resize(first_ > last ? 1 : static_cast<std::size_t>((last - first_) / kRow) + 1);
        for (std::uint32_t k = 0; k < corners_.size(); ++k) {
            const Place &p = corners_[k], &q = corners_[(k + 1) % corners_.size()];
            const std::size_t from = row_of(3 * std::int64_t{std::min(p.y, q.y)}),
                              to = row_of(3 * std::int64_t{std::max(p.y, q.y)});
            for (std::size_t row = from; row <= to; ++row) rows_[row].push_back(k);
        }
    }
    std::size_t row_of(std::int64_t y) const {
        return static_cast<std::size_t>(
            std::clamp<std::int64_t>((y - first_) / kRow, 0, static_cast<std::int64_t>(rows_.size()) - 1));
    }
    // True if side k passes left of a centre; x, y: three times its place. Sides upwards and downwards are
    // treated alike, so that the two tiles agree.
    bool passes_left_of(std::uint32_t k, std::int64_t x, std::int64_t y) const {
        Place p = corners_[k], q = corners_[(k + 1) % corners_.size()];
        if (p.y > q.y) std::swap(p, q);
        const std::int64_t py = 3 * std::int64_t{p.y}, qy = 3 * std::int64_t{q.y};
        if (!(py <= y && y < qy)) return false;
        // Both sides of the comparison are divided by 3, because the products must fit into 64 bits.
        return (x - 3 * std::int64_t{p.x}) * ((qy - py) / 3) > (y - py) * (std::int64_t{q.x} - p.x);
    }

    std::vector<Place> corners_;
    // The innermost coordinates that the four sides reach.
    std::int32_t left_ = -kFar, right_ = kFar, top_ = -kFar, bottom_ = kFar;
    std::int64_t first_ = 0;
    std::vector<std::vector<std::uint32_t>> rows_;
};

HexMesh2D lattice_in(const LatticeBlock& block, const MapRect& window) {
    HexMesh2D mesh{block.columns, block.rows, {}};
    mesh.positions.reserve(block.places.size());
    for (const Place& p : block.places) mesh.positions.push_back(in_window(p, window));
    return mesh;
}

// The kinds of triangles that a corner has.
constexpr std::uint8_t kOwned = 1, kOthers = 2, kBoth = 3;

// Returns the edges that an owned triangle shares with one that is not owned. kinds: kinds of each corner.
std::vector<std::array<TileCorner, 2>> edges_between(const DisparityMesh& mesh,
                                                     const std::vector<bool>& owned,
                                                     const std::vector<std::uint8_t>& kinds,
                                                     const std::vector<TileCorner>& corners) {
    std::vector<std::array<std::uint32_t, 2>> own, others;  // directed edges
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        // Both ends of such an edge have triangles of both kinds, which is true of few corners.
        const Triangle& triangle = mesh.triangles[t];
        const bool at[3] = {kinds[triangle[0]] == kBoth, kinds[triangle[1]] == kBoth,
                            kinds[triangle[2]] == kBoth};
        if (at[0] + at[1] + at[2] < 2) continue;
        for (std::size_t k = 0; k < 3; ++k)
            if (at[k] && at[(k + 1) % 3])
                (owned[t] ? own : others).push_back({triangle[k], triangle[(k + 1) % 3]});
    }
    std::sort(others.begin(), others.end());
    std::vector<std::array<TileCorner, 2>> found;
    for (const auto& [a, b] : own)
        if (std::binary_search(others.begin(), others.end(), std::array{b, a}))
            found.push_back({corners[a], corners[b]});
    std::sort(found.begin(), found.end());
    return found;
}

}  // namespace

void rounded_disparities(DisparityMap& map) {
    // Rounds like std::round(), without a call per pixel; from kAllWhole on all floats are whole.
    constexpr float kSteps = 65536, kAllWhole = 1 << 23;
    for (float& d : map.values) {
        const float steps = d * kSteps;
        const bool has_rest = std::abs(steps) < kAllWhole;
        const float below = static_cast<float>(static_cast<std::int32_t>(has_rest ? steps : 0.0f)),
                    rest = steps - below;
        const float rounded =
            (below + static_cast<float>(rest >= 0.5f) - static_cast<float>(rest <= -0.5f)) / kSteps;
        d = has_rest ? rounded : d;
    }
}

TileSurface cut_tile(const LatticeTiling& tiling, int i, int j, const LatticeBlock& block,
                     const TileSurfaceInput& input, const SurfaceConfig& config, int threads,
                     const CutMesh& cut) {
    const HexMesh2D lattice = lattice_in(block, input.window);
    surface::WholeMap whole = input.whole;
    whole.columns = tiling.columns();
    whole.first_column = block.first_column;
    whole.first_row = block.first_row;
    const DisparityMesh all = cut({&lattice, input.map, input.background_px, whole}, config, threads);

    std::vector<TileCorner> corners;
    corners.reserve(all.points.size());
    for (std::size_t v = 0; v < all.points.size(); ++v)
        corners.push_back({place_of(all.points[v], input.window), all.disparities[v]});
    const TileBorder border(tiling, i, j, block);
    std::vector<bool> owned;
    owned.reserve(all.triangles.size());
    std::vector<std::uint8_t> kinds(corners.size(), 0);
    for (const Triangle& t : all.triangles) {
        const bool is_own = border.holds(corners[t[0]].place, corners[t[1]].place, corners[t[2]].place);
        owned.push_back(is_own);
        for (const std::uint32_t v : t) kinds[v] |= is_own ? kOwned : kOthers;
    }

    TileSurface surface;
    surface.mesh.points.reserve(all.points.size());
    surface.mesh.disparities.reserve(all.points.size());
    surface.mesh.triangles.reserve(all.triangles.size());
    surface.seam_edges = edges_between(all, owned, kinds, corners);
    std::vector<std::uint32_t> numbers(all.points.size());
    for (std::size_t v = 0; v < all.points.size(); ++v) {
        if (!(kinds[v] & kOwned)) continue;
        numbers[v] = static_cast<std::uint32_t>(surface.mesh.points.size());
        surface.mesh.points.push_back(all.points[v]);
        surface.mesh.disparities.push_back(all.disparities[v]);
    }
    for (std::size_t t = 0; t < all.triangles.size(); ++t) {
        const Triangle& corner = all.triangles[t];
        if (owned[t])
            surface.mesh.triangles.push_back({numbers[corner[0]], numbers[corner[1]], numbers[corner[2]]});
    }
    return surface;
}

TileMesh tile_mesh_of(const TileSurface& surface, const MapRect& window) {
    TileMesh mesh{{}, surface.mesh.triangles, surface.seam_edges};
    mesh.corners.reserve(surface.mesh.points.size());
    for (std::size_t v = 0; v < surface.mesh.points.size(); ++v)
        mesh.corners.push_back({place_of(surface.mesh.points[v], window), surface.mesh.disparities[v]});
    return mesh;
}

}  // namespace hexrelief::mesh_tiles
