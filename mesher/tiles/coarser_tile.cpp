#include "mesher/tiles/coarser_tile.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "mesher/tiles/fold_mender.h"

namespace hexrelief::mesh_tiles {
namespace {

// Returns the tiles' seam edges whose other triangle is in none of the tiles, in order.
std::vector<SeamEdge> outer_edges(std::span<const TileMesh> tiles) {
    std::vector<SeamEdge> edges;
    for (const TileMesh& tile : tiles)
        edges.insert(edges.end(), tile.seam_edges.begin(), tile.seam_edges.end());
    std::sort(edges.begin(), edges.end());
    std::vector<SeamEdge> outer;
    for (const SeamEdge& edge : edges)
        if (!std::binary_search(edges.begin(), edges.end(), SeamEdge{edge[1], edge[0]}))
            outer.push_back(edge);
    return outer;
}

struct PlaceHash {
    std::size_t operator()(const TileCorner& corner) const {
        return (static_cast<std::size_t>(static_cast<std::uint32_t>(corner.place.x)) << 32 |
                static_cast<std::uint32_t>(corner.place.y)) *
                   0x9e3779b97f4a7c15u >>
               20;
    }
};
// The corners at seams, with their numbers in the joined mesh.
using SeamCorners = std::unordered_map<TileCorner, std::uint32_t, PlaceHash>;
constexpr std::uint32_t kNew = 0xffffffffu;

SeamCorners seam_corners(std::span<const TileMesh> tiles) {
    SeamCorners corners;
    for (const TileMesh& tile : tiles)
        for (const SeamEdge& edge : tile.seam_edges)
            for (const TileCorner& corner : edge) corners.emplace(corner, kNew);
    return corners;
}

// Joins the tiles' meshes; equal corners at seams become one.
TileMesh joined(std::span<const TileMesh> tiles) {
    SeamCorners at_seams = seam_corners(tiles);
    TileMesh all;
    std::vector<std::uint32_t> numbers;
    for (const TileMesh& tile : tiles) {
        numbers.clear();
        for (const TileCorner& corner : tile.corners) {
            const auto next = static_cast<std::uint32_t>(all.corners.size());
            const auto seam = at_seams.find(corner);
            if (seam != at_seams.end() && seam->second != kNew) {
                numbers.push_back(seam->second);
                continue;
            }
            if (seam != at_seams.end()) seam->second = next;
            numbers.push_back(next);
            all.corners.push_back(corner);
        }
        for (const Triangle& t : tile.triangles)
            all.triangles.push_back({numbers[t[0]], numbers[t[1]], numbers[t[2]]});
    }
    all.seam_edges = outer_edges(tiles);
    return all;
}

// Weight of disparities relative to px: small, so that silhouettes stay in place. Root mean square
// differences in disparity at a quarter of the triangles of four tiles, with weights of .2, .05, .02, .01,
// .003: .83, .21, .15, .048, .048 px.
constexpr float kDisparityWeight = 0.01f;

// The input of meshoptimizer: px, and weighted disparities. Two additional vertices form a triangle with each
// vertex that is to stay, which makes that vertex non-manifold: meshoptimizer does not move such vertices.
class Simplifier {
  public:
    explicit Simplifier(const TileMesh& mesh) : mesh_(mesh) {
        Place least = mesh.corners.front().place;
        for (const TileCorner& c : mesh.corners)
            least = {std::min(least.x, c.place.x), std::min(least.y, c.place.y)};
        for (const TileCorner& c : mesh.corners)
            points_.push_back({static_cast<float>(c.place.x - least.x) / kPlacesPerPixel,
                               static_cast<float>(c.place.y - least.y) / kPlacesPerPixel,
                               c.disparity * kDisparityWeight});
        for (const Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
        points_.insert(points_.end(), {{-1, -1, 0}, {-1, -2, 0}});
        hold(seam_vertices());
    }

    // Keeps these vertices in place from now on.
    void hold(const std::vector<std::uint32_t>& vertices) {
        const auto p = static_cast<std::uint32_t>(mesh_.corners.size());
        for (const std::uint32_t v : vertices) indices_.insert(indices_.end(), {v, p, p + 1});
    }
    // Keeps these vertices and their neighbours in place, because a neighbour's move may have made the fold.
    void hold_around(const std::vector<std::uint32_t>& vertices) {
        std::vector<bool> is_one(mesh_.corners.size()), around(mesh_.corners.size());
        for (const std::uint32_t v : vertices) is_one[v] = true;
        for (const Triangle& t : mesh_.triangles)
            if (is_one[t[0]] || is_one[t[1]] || is_one[t[2]])
                for (const std::uint32_t v : t) around[v] = true;
        std::vector<std::uint32_t> held;
        for (std::uint32_t v = 0; v < around.size(); ++v)
            if (around[v]) held.push_back(v);
        hold(held);
    }

    // Returns the triangles left when about `share` of them is kept.
    std::vector<Triangle> simplified(double share) const {
        const std::size_t real = 3 * mesh_.triangles.size(), extra = indices_.size() - real;
        const std::size_t wanted =
            static_cast<std::size_t>(std::min(share, 1.0) * static_cast<double>(real)) / 3 * 3 + extra;
        std::vector<std::uint32_t> left(indices_.size());
        left.resize(meshopt_simplify(left.data(), indices_.data(), indices_.size(), &points_[0].x,
                                     points_.size(), sizeof(Vec3f), wanted, kAnyError, 0, nullptr));
        std::vector<Triangle> triangles;
        for (std::size_t k = 0; k < left.size(); k += 3) {
            const Triangle t = {left[k], left[k + 1], left[k + 2]};
            if (std::max({t[0], t[1], t[2]}) < mesh_.corners.size()) triangles.push_back(t);
        }
        return triangles;
    }

  private:
    static constexpr float kAnyError = 1e6f;

    std::vector<std::uint32_t> seam_vertices() const {
        const SeamCorners corners = seam_corners({&mesh_, 1});
        std::vector<std::uint32_t> found;
        for (std::uint32_t v = 0; v < mesh_.corners.size(); ++v)
            if (corners.contains(mesh_.corners[v])) found.push_back(v);
        return found;
    }

    const TileMesh& mesh_;
    std::vector<Vec3f> points_;
    std::vector<std::uint32_t> indices_;
};

// Finds triangles by the squares of the image that their bounding boxes touch.
class TriangleIndex {
  public:
    explicit TriangleIndex(const TileMesh& mesh) : mesh_(mesh) {
        Place most = low_ = mesh.corners.front().place;
        for (const TileCorner& c : mesh.corners) {
            low_ = {std::min(low_.x, c.place.x), std::min(low_.y, c.place.y)};
            most = {std::max(most.x, c.place.x), std::max(most.y, c.place.y)};
        }
        const double width = double(most.x) - low_.x + 1, height = double(most.y) - low_.y + 1;
        side_ =
            std::max(1.0, std::sqrt(width * height / (static_cast<double>(mesh.triangles.size()) + 1)) * 1.5);
        columns_ = static_cast<int>(width / side_) + 1;
        rows_ = static_cast<int>(height / side_) + 1;
        starts_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
        for (const bool counts : {true, false}) {
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
                visit(mesh.triangles[t], [&](std::size_t square) {
                    if (counts)
                        ++starts_[square + 1];
                    else
                        members_[--ends_[square]] = t;
                });
            if (!counts) break;
            for (std::size_t k = 1; k < starts_.size(); ++k) starts_[k] += starts_[k - 1];
            ends_.assign(starts_.begin() + 1, starts_.end());
            members_.resize(starts_.back());
        }
    }

    // Returns the disparity of the mesh at a corner's place, of several triangles the one nearest to the
    // corner's own; nullopt if no triangle is there.
    std::optional<double> disparity_at(const TileCorner& corner) const {
        std::optional<double> nearest;
        const int column = column_of(corner.place.x), row = row_of(corner.place.y);
        if (corner.place.x < low_.x || column >= columns_ || corner.place.y < low_.y || row >= rows_)
            return std::nullopt;
        const std::size_t square = static_cast<std::size_t>(row) * columns_ + column;
        for (std::uint32_t k = starts_[square]; k < starts_[square + 1]; ++k) {
            const Triangle& t = mesh_.triangles[members_[k]];
            std::array<double, 3> weights{};
            double sum = 0;
            bool within = true;
            for (std::size_t m = 0; m < 3; ++m) {
                const Place &p = mesh_.corners[t[(m + 1) % 3]].place,
                            &q = mesh_.corners[t[(m + 2) % 3]].place;
                const std::int64_t area = (std::int64_t{q.x} - p.x) * (std::int64_t{corner.place.y} - p.y) -
                                          (std::int64_t{q.y} - p.y) * (std::int64_t{corner.place.x} - p.x);
                within = within && area >= 0;
                sum += weights[m] = static_cast<double>(area);
            }
            if (!within || sum == 0) continue;
            double disparity = 0;
            for (std::size_t m = 0; m < 3; ++m) disparity += weights[m] / sum * mesh_.corners[t[m]].disparity;
            if (!nearest || std::abs(disparity - corner.disparity) < std::abs(*nearest - corner.disparity))
                nearest = disparity;
        }
        return nearest;
    }

  private:
    int column_of(std::int32_t x) const { return static_cast<int>((double(x) - low_.x) / side_); }
    int row_of(std::int32_t y) const { return static_cast<int>((double(y) - low_.y) / side_); }
    template <typename Visit>
    void visit(const Triangle& t, const Visit& each) const {
        const Place &a = mesh_.corners[t[0]].place, &b = mesh_.corners[t[1]].place,
                    &c = mesh_.corners[t[2]].place;
        for (int row = row_of(std::min({a.y, b.y, c.y})); row <= row_of(std::max({a.y, b.y, c.y})); ++row)
            for (int column = column_of(std::min({a.x, b.x, c.x}));
                 column <= column_of(std::max({a.x, b.x, c.x})); ++column)
                each(static_cast<std::size_t>(row) * columns_ + column);
    }

    const TileMesh& mesh_;
    Place low_;
    double side_ = 1;
    int columns_ = 1, rows_ = 1;
    std::vector<std::uint32_t> starts_, ends_, members_;
};

// One corner in kMeasuredCorners is measured, which is enough for a mean.
constexpr std::size_t kMeasuredCorners = 4;

// Returns a mesh of some triangles of `whole`, without its unused corners.
TileMesh with_triangles(const TileMesh& whole, const std::vector<Triangle>& triangles) {
    constexpr std::uint32_t kUnused = 0xffffffffu;
    std::vector<std::uint32_t> numbers(whole.corners.size(), kUnused);
    TileMesh mesh{{}, {}, whole.seam_edges};
    for (const Triangle& t : triangles) {
        Triangle& own = mesh.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            std::uint32_t& number = numbers[t[k]];
            if (number == kUnused) {
                number = static_cast<std::uint32_t>(mesh.corners.size());
                mesh.corners.push_back(whole.corners[t[k]]);
            }
            own[k] = number;
        }
    }
    return mesh;
}

}  // namespace

TileMesh simplified(const TileMesh& mesh, double share) {
    constexpr int kAttempts = 8;  // each with more vertices held, while triangles remain turned over
    if (mesh.empty()) return {{}, {}, mesh.seam_edges};
    Simplifier simplifier(mesh);
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        std::vector<Triangle> triangles = simplifier.simplified(share);
        const std::vector<std::uint32_t> folds = mend_folds(mesh, triangles);
        if (triangles.empty()) break;
        if (folds.empty()) return with_triangles(mesh, triangles);
        simplifier.hold_around(folds);
    }
    return mesh;
}

TileMesh simplified_alone(const TileMesh& tile, double share) {
    constexpr double kMore = 1.4;
    return simplified(tile, kMore * share);
}

CoarserTile coarser_tile(std::span<const TileMesh> tiles, std::span<const TileMesh> parts, double share,
                         const DepthOf& depth) {
    const auto triangles = [](std::span<const TileMesh> meshes) {
        double count = 0;
        for (const TileMesh& mesh : meshes) count += static_cast<double>(mesh.triangles.size());
        return count;
    };
    CoarserTile coarser{
        simplified(joined(parts), share * triangles(tiles) / std::max(1.0, triangles(parts)))};
    if (coarser.mesh.empty()) return coarser;

    // corners at which the surface has no triangle are skipped
    const TriangleIndex surface(coarser.mesh);
    double squares_px = 0, squares_m = 0, count = 0;
    for (const TileMesh& tile : tiles)
        for (std::size_t v = 0; v < tile.corners.size(); v += kMeasuredCorners) {
            const TileCorner& corner = tile.corners[v];
            const std::optional<double> disparity = surface.disparity_at(corner);
            if (!disparity) continue;
            const double px = *disparity - corner.disparity, m = depth(*disparity) - depth(corner.disparity);
            squares_px += px * px;
            squares_m += m * m;
            ++count;
        }
    if (count > 0) {
        coarser.error_px = std::sqrt(squares_px / count);
        coarser.error_m = std::sqrt(squares_m / count);
    }
    return coarser;
}

}  // namespace hexrelief::mesh_tiles
