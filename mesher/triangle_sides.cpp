#include <algorithm>
#include <cmath>
#include <numeric>

#include "mesher/sheet_parts.h"

namespace hexrelief {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::uint32_t kMixed_px = 3;  // pixels of other sides that make a triangle mixed
constexpr double kMixedShare = 0.15;    // and their share of its own

// Calls visit(x, y) for the pixels whose centres lie in the triangle, its edges included, row by row.
template <typename Visit>
void each_pixel(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c, const Visit& visit) {
    const auto first = [](float v) { return std::max(0, static_cast<int>(std::ceil(v - 0.5f))); };
    const auto last = [](float v, int size) {
        return std::min(size - 1, static_cast<int>(std::floor(v - 0.5f)));
    };
    const int x0 = first(std::min({a.x, b.x, c.x})), x1 = last(std::max({a.x, b.x, c.x}), width);
    const int y0 = first(std::min({a.y, b.y, c.y})), y1 = last(std::max({a.y, b.y, c.y}), height);
    const auto edge = [](const Vec2f& p, const Vec2f& q, double x, double y) {
        return (double(q.x) - p.x) * (y - p.y) - (double(q.y) - p.y) * (x - p.x);
    };
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const double u = x + 0.5, v = y + 0.5;
            if (edge(a, b, u, v) >= 0 && edge(b, c, u, v) >= 0 && edge(c, a, u, v) >= 0) visit(x, y);
        }
}

class SideFinder {
  public:
    SideFinder(const PixelSurfaces& surfaces, const SplitLattice& lattice)
        : view_(surfaces.view()), jump_px_(surfaces.jump_px), lattice_(lattice) {}

    TriangleSides run() {
        own_pixels();
        connect_pixels();
        choose_sides();
        vote();
        return std::move(sides_);
    }

  private:
    std::size_t pixel_count() const { return static_cast<std::size_t>(view_.width) * view_.height; }

    // Each pixel's triangle; on an edge the first one.
    void own_pixels() {
        owner_.assign(pixel_count(), kNone);
        for (std::uint32_t t = 0; t < lattice_.triangles.size(); ++t) {
            const Triangle& v = lattice_.triangles[t];
            each_pixel(view_.width, view_.height, lattice_.points[v[0]], lattice_.points[v[1]],
                       lattice_.points[v[2]], [&](int x, int y) {
                           std::uint32_t& owner = owner_[view_.index(x, y)];
                           if (owner == kNone) owner = t;
                       });
        }
    }
    std::uint32_t root(std::uint32_t i) {
        while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        parents_[std::max(a, b)] = std::min(a, b);
    }
    // Pieces: pixels of one triangle that hang together without a jump, diagonally too.
    void connect_pixels() {
        parents_.resize(pixel_count());
        std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
        const std::uint32_t w = static_cast<std::uint32_t>(view_.width);
        for (int y = 0; y < view_.height; ++y)
            for (int x = 0; x < view_.width; ++x) {
                const std::uint32_t i = static_cast<std::uint32_t>(view_.index(x, y));
                const std::uint32_t t = owner_[i];
                if (t == kNone) continue;
                const bool east = x + 1 < view_.width, south = y + 1 < view_.height;
                if (east && owner_[i + 1] == t && !(view_.flags[i] & step::kJumpRight)) join(i, i + 1);
                if (south && owner_[i + w] == t && !(view_.flags[i] & step::kJumpDown)) join(i, i + w);
                if (!east || !south) continue;
                const bool right = view_.flags[i] & step::kJumpRight, down = view_.flags[i] & step::kJumpDown;
                const bool far_down = view_.flags[i + 1] & step::kJumpDown,
                           low_right = view_.flags[i + w] & step::kJumpRight;
                if (owner_[i + w + 1] == t && ((!right && !far_down) || (!down && !low_right)))
                    join(i, i + w + 1);
                if (owner_[i + 1] == t && owner_[i + w] == t)
                    continue;  // joined through this pixel or cut off
            }
        for (int y = 0; y + 1 < view_.height; ++y)
            for (int x = 1; x < view_.width; ++x) {  // to the lower left
                const std::uint32_t i = static_cast<std::uint32_t>(view_.index(x, y));
                const std::uint32_t t = owner_[i];
                if (t == kNone || owner_[i + w - 1] != t) continue;
                const bool left = view_.flags[i - 1] & step::kJumpRight,
                           down = view_.flags[i] & step::kJumpDown;
                const bool left_down = view_.flags[i - 1] & step::kJumpDown,
                           low_left = view_.flags[i + w - 1] & step::kJumpRight;
                if ((!left && !left_down) || (!down && !low_left)) join(i, i + w - 1);
            }
    }
    // The largest piece of each triangle is its side; a triangle without pixels lies where its middle does.
    void choose_sides() {
        const std::size_t count = lattice_.triangles.size();
        std::vector<std::uint32_t> areas(pixel_count(), 0);
        for (std::uint32_t i = 0; i < pixel_count(); ++i)
            if (owner_[i] != kNone) ++areas[parents_[i] = root(i)];
        side_.assign(count, kNone);
        for (std::uint32_t i = 0; i < pixel_count(); ++i) {
            if (areas[i] == 0) continue;  // not a root
            std::uint32_t& side = side_[owner_[i]];
            if (side == kNone || areas[i] > areas[side]) side = i;
        }
        sides_.kept.assign(count, 0);
        anchors_.resize(count);
        sides_.starts.assign(count + 1, 0);
        for (std::uint32_t t = 0; t < count; ++t) {
            anchors_[t] = side_[t] == kNone ? middle_pixel(t) : side_[t];
            sides_.kept[t] = view_.disparity[anchors_[t]] > 0;
        }
        find_mixed(areas);
        const auto fitted = [&](std::uint32_t i) {
            return ruling(i) && sides_.kept[owner_[i]] && (view_.flags[i] & step::kTrusted);
        };
        for (std::uint32_t i = 0; i < pixel_count(); ++i)
            if (fitted(i)) ++sides_.starts[owner_[i] + 1];
        std::partial_sum(sides_.starts.begin(), sides_.starts.end(), sides_.starts.begin());
        sides_.pixels.resize(sides_.starts.back());
        std::vector<std::uint32_t> next(sides_.starts.begin(), sides_.starts.end() - 1);
        for (std::uint32_t i = 0; i < pixel_count(); ++i)
            if (fitted(i)) sides_.pixels[next[owner_[i]]++] = i;
    }
    void find_mixed(const std::vector<std::uint32_t>& areas) {
        std::vector<std::uint32_t> all(lattice_.triangles.size(), 0);
        for (std::uint32_t i = 0; i < pixel_count(); ++i)
            if (owner_[i] != kNone) ++all[owner_[i]];
        sides_.mixed.assign(all.size(), 0);
        for (std::uint32_t t = 0; t < all.size(); ++t) {
            if (side_[t] == kNone) continue;
            const std::uint32_t stray = all[t] - areas[side_[t]];
            sides_.mixed[t] = stray >= kMixed_px && stray >= kMixedShare * static_cast<double>(all[t]);
        }
    }
    std::uint32_t middle_pixel(std::uint32_t t) const {
        const Triangle& v = lattice_.triangles[t];
        const auto& p = lattice_.points;
        const int x = static_cast<int>((p[v[0]].x + p[v[1]].x + p[v[2]].x) / 3),
                  y = static_cast<int>((p[v[0]].y + p[v[1]].y + p[v[2]].y) / 3);
        return static_cast<std::uint32_t>(
            view_.index(std::clamp(x, 0, view_.width - 1), std::clamp(y, 0, view_.height - 1)));
    }
    bool ruling(std::uint32_t i) const { return owner_[i] != kNone && parents_[i] == side_[owner_[i]]; }

    // Pairs of neighbouring pixels across each edge say whether its two sides are one surface.
    void vote() {
        const std::size_t count = lattice_.triangles.size();
        std::vector<std::array<int, 3>> votes(count, {0, 0, 0}), pairs(count, {0, 0, 0});
        const auto pair = [&](std::uint32_t i, std::uint32_t j, bool jump) {
            const std::uint32_t a = owner_[i], b = owner_[j];
            if (a == b || a == kNone || b == kNone) return;
            const bool first = ruling(i), second = ruling(j);
            int vote = 0;
            if (first && second)
                vote = jump ? 1 : -1;
            else if (first != second && !jump)
                vote = 1;  // the one's surface goes on beyond the edge, but as the lesser part
            else
                return;
            for (int k = 0; k < 3; ++k) {
                if (lattice_.neighbours[a][k] == static_cast<std::int32_t>(b))
                    votes[a][k] += vote, ++pairs[a][k];
                if (lattice_.neighbours[b][k] == static_cast<std::int32_t>(a))
                    votes[b][k] += vote, ++pairs[b][k];
            }
        };
        const std::uint32_t w = static_cast<std::uint32_t>(view_.width);
        for (std::uint32_t i = 0; i < pixel_count(); ++i) {
            if ((i + 1) % w != 0) pair(i, i + 1, view_.flags[i] & step::kJumpRight);
            if (i + w < pixel_count()) pair(i, i + w, view_.flags[i] & step::kJumpDown);
        }
        sides_.open.assign(count, {0, 0, 0});
        for (std::uint32_t t = 0; t < count; ++t)
            for (int k = 0; k < 3; ++k) {
                const std::int32_t other = lattice_.neighbours[t][k];
                if (other < 0) continue;
                sides_.open[t][k] =
                    pairs[t][k] > 0 ? votes[t][k] > 0 : differ(t, static_cast<std::uint32_t>(other));
            }
    }
    // Without pixels along the edge: whether the triangles' own pixels are too different for their distance.
    bool differ(std::uint32_t a, std::uint32_t b) const {
        const std::uint32_t i = anchors_[a], j = anchors_[b], w = static_cast<std::uint32_t>(view_.width);
        const auto apart = [](std::uint32_t p, std::uint32_t q) {
            return static_cast<float>(p > q ? p - q : q - p);
        };
        const float distance = std::max(apart(i % w, j % w), apart(i / w, j / w));
        return step::is_jump(view_.disparity[i], view_.disparity[j], jump_px_ + distance);
    }

    step::PixelView view_;
    float jump_px_;
    const SplitLattice& lattice_;
    TriangleSides sides_;
    std::vector<std::uint32_t> owner_, parents_;
    std::vector<std::uint32_t> side_, anchors_;  // a triangle: its piece's root; a pixel of its side
};

}  // namespace

TriangleSides find_sides(const PixelSurfaces& surfaces, const SplitLattice& lattice) {
    return SideFinder(surfaces, lattice).run();
}

std::vector<std::uint32_t> open_fans(const SplitLattice& lattice, const TriangleSides& sides,
                                     std::vector<Triangle>& triangles, std::vector<std::uint32_t>& origins) {
    // corners joined across closed edges, by disjoint sets whose root is the first corner
    std::vector<std::uint32_t> parents(3 * lattice.triangles.size());
    std::iota(parents.begin(), parents.end(), std::uint32_t{0});
    const auto root = [&](std::uint32_t i) {
        while (parents[i] != i) i = parents[i] = parents[parents[i]];
        return i;
    };
    const auto corner_of = [&](std::uint32_t t, std::uint32_t vertex) {
        const Triangle& v = lattice.triangles[t];
        return 3 * t + (v[0] == vertex ? 0u : v[1] == vertex ? 1u : 2u);
    };
    for (std::uint32_t t = 0; t < lattice.triangles.size(); ++t) {
        if (!sides.kept[t]) continue;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::int32_t n = lattice.neighbours[t][k];
            if (n <= static_cast<std::int32_t>(t) || !sides.kept[n] || sides.open[t][k]) continue;
            for (const std::uint32_t c : {k, (k + 1) % 3}) {
                const std::uint32_t a = root(3 * t + c), b = root(corner_of(static_cast<std::uint32_t>(n),
                                                                            lattice.triangles[t][c]));
                parents[std::max(a, b)] = std::min(a, b);
            }
        }
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> fans;  // vertex, first corner
    for (std::uint32_t i = 0; i < parents.size(); ++i)
        if (sides.kept[i / 3] && root(i) == i) fans.emplace_back(lattice.triangles[i / 3][i % 3], i);
    std::sort(fans.begin(), fans.end());
    std::vector<std::uint32_t> number(parents.size()), olds;
    for (const auto& [vertex, first] : fans) {
        number[first] = static_cast<std::uint32_t>(olds.size());
        olds.push_back(vertex);
    }
    triangles.clear();
    origins.clear();
    for (std::uint32_t t = 0; t < lattice.triangles.size(); ++t) {
        if (!sides.kept[t]) continue;
        triangles.push_back({number[root(3 * t)], number[root(3 * t + 1)], number[root(3 * t + 2)]});
        origins.push_back(t);
    }
    return olds;
}

}  // namespace hexrelief
