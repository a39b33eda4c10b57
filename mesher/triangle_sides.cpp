#include <algorithm>
#include <cmath>
#include <numeric>

#include "mesher/sheet_parts.h"
#include "mesher/team.h"

namespace hexrelief {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::uint32_t kMixed_px = 3;  // pixels of other sides that make a triangle mixed
constexpr double kMixedShare = 0.15;    // and their share of its own

// One side of a triangle. A pixel centre on a shared side belongs to exactly one of the two triangles: both
// compute the same number but for its sign.
struct Side {
    double x, y, dx, dy;
    bool turned;

    Side(Vec2f a, Vec2f b) : turned(b.y < a.y || (b.y == a.y && b.x < a.x)) {
        if (turned) std::swap(a, b);
        x = a.x;
        y = a.y;
        dx = double(b.x) - a.x;
        dy = double(b.y) - a.y;
    }
    bool holds(double u, double v) const {
        const double e = dx * (v - y) - dy * (u - x);
        return turned ? e < 0 : e >= 0;
    }
};

// Calls visit(x, y) for the pixels whose centres lie in the triangle, row by row.
template <typename Visit>
void each_pixel(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c, const Visit& visit) {
    const auto first = [](float v) { return std::max(0, static_cast<int>(std::ceil(v - 0.5f))); };
    const auto last = [](float v, int size) {
        return std::min(size - 1, static_cast<int>(std::floor(v - 0.5f)));
    };
    const int x0 = first(std::min({a.x, b.x, c.x})), x1 = last(std::max({a.x, b.x, c.x}), width);
    const int y0 = first(std::min({a.y, b.y, c.y})), y1 = last(std::max({a.y, b.y, c.y}), height);
    const Side ab(a, b), bc(b, c), ca(c, a);
    for (int y = y0; y <= y1; ++y) {
        bool met = false;
        for (int x = x0; x <= x1; ++x) {
            const double u = x + 0.5, v = y + 0.5;
            if (ab.holds(u, v) && bc.holds(u, v) && ca.holds(u, v)) {
                visit(x, y);
                met = true;
            } else if (met) {
                break;  // a row meets a triangle once
            }
        }
    }
}

template <typename Visit>
void each_own(const step::PixelView& view, const SplitLattice& lattice, std::uint32_t t, const Visit& visit) {
    const Triangle& v = lattice.triangles[t];
    each_pixel(view.width, view.height, lattice.points[v[0]], lattice.points[v[1]], lattice.points[v[2]],
               [&](int x, int y) { visit(x, y, static_cast<std::uint32_t>(view.index(x, y))); });
}

std::uint32_t middle_pixel(const step::PixelView& view, const SplitLattice& lattice, std::uint32_t t) {
    const Triangle& v = lattice.triangles[t];
    const auto& p = lattice.points;
    const int x = static_cast<int>((p[v[0]].x + p[v[1]].x + p[v[2]].x) / 3),
              y = static_cast<int>((p[v[0]].y + p[v[1]].y + p[v[2]].y) / 3);
    return static_cast<std::uint32_t>(
        view.index(std::clamp(x, 0, view.width - 1), std::clamp(y, 0, view.height - 1)));
}

}  // namespace

// Every step works on one triangle's own pixels, so that triangles can be shared out among threads.

SideFinder::SideFinder(const PixelSurfaces& surfaces, Team& team)
    : view_(surfaces.view()),
      jump_px_(surfaces.jump_px),
      team_(team),
      owner_(surfaces.disparity.size(), kNone),
      piece_(surfaces.disparity.size()) {}

template <typename Work>
void SideFinder::each_triangle(const SplitLattice& lattice, const Work& work) {
    team_.for_ranges(lattice.triangles.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t t = first; t < last; ++t) work(static_cast<std::uint32_t>(t));
    });
}

void SideFinder::update(SplitLattice& lattice) {
    const std::size_t count = lattice.triangles.size();
    const auto changed = [&](std::int32_t t) { return t >= 0 && lattice.changed[t]; };
    team_.for_ranges(owner_.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i)
            if (owner_[i] != kNone && lattice.changed[owner_[i]]) owner_[i] = kNone;
    });
    side_.resize(count, kNone);
    anchors_.resize(count);
    areas_.resize(count, 0);
    plain_.resize(count, 0);
    sides_.kept.resize(count, 0);
    sides_.mixed.resize(count, 0);
    sides_.open.resize(count, {0, 0, 0});
    each_triangle(lattice, [&](std::uint32_t t) {
        if (lattice.changed[t]) own_pixels(lattice, t);
    });
    each_triangle(lattice, [&](std::uint32_t t) {
        if (lattice.changed[t]) choose_side(lattice, t);
    });
    each_triangle(lattice, [&](std::uint32_t t) {
        const auto& n = lattice.neighbours[t];
        if (lattice.changed[t] || changed(n[0]) || changed(n[1]) || changed(n[2])) vote(lattice, t);
    });
    lattice.changed.assign(count, 0);
}

void SideFinder::own_pixels(const SplitLattice& lattice, std::uint32_t t) {
    std::uint32_t first = kNone;
    areas_[t] = 0;
    bool plain = true;
    each_own(view_, lattice, t, [&](int, int, std::uint32_t i) {
        if (first == kNone) first = i;
        owner_[i] = t;
        piece_[i] = first;
        plain = plain && !(view_.flags[i] & (step::kJumpRight | step::kJumpDown));
        ++areas_[t];
    });
    side_[t] = first;
    plain_[t] = plain;
}

std::uint32_t SideFinder::root(std::uint32_t i) {
    while (piece_[i] != i) i = piece_[i] = piece_[piece_[i]];
    return i;
}

void SideFinder::join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    piece_[std::max(a, b)] = std::min(a, b);
}

bool SideFinder::jump(int x, int y, int dx, int dy) const {
    return step::has_crack(view_, step::crack_between(x, y, dx, dy));
}

// Joins a pixel with those of its own triangle on the right and below, diagonally too, that no jump parts
// from it.
void SideFinder::connect(std::uint32_t t, int x, int y, std::uint32_t i) {
    const std::uint32_t w = static_cast<std::uint32_t>(view_.width);
    const bool east = x + 1 < view_.width, south = y + 1 < view_.height;
    if (east && owner_[i + 1] == t && !jump(x, y, 1, 0)) join(i, i + 1);
    if (south && owner_[i + w] == t && !jump(x, y, 0, 1)) join(i, i + w);
    for (const int dx : {1, -1}) {
        if (!south || x + dx < 0 || x + dx >= view_.width || owner_[i + w + dx] != t) continue;
        if ((!jump(x, y, dx, 0) && !jump(x + dx, y, 0, 1)) || (!jump(x, y, 0, 1) && !jump(x, y + 1, dx, 0)))
            join(i, i + w + dx);
    }
}

// The largest piece of a triangle is its side; a triangle without pixels lies where its middle does.
void SideFinder::choose_side(const SplitLattice& lattice, std::uint32_t t) {
    const std::uint32_t all = areas_[t];
    sides_.mixed[t] = 0;
    if (!plain_[t]) {
        std::vector<std::uint32_t> own;
        each_own(view_, lattice, t, [&](int, int, std::uint32_t i) { own.push_back(i), piece_[i] = i; });
        const std::uint32_t w = static_cast<std::uint32_t>(view_.width);
        for (const std::uint32_t i : own) connect(t, static_cast<int>(i % w), static_cast<int>(i / w), i);
        for (std::uint32_t& i : own) i = piece_[i] = root(i);
        std::sort(own.begin(), own.end());
        std::uint32_t best = 0;
        for (std::size_t first = 0, last = 0; first < own.size(); first = last) {
            while (last < own.size() && own[last] == own[first]) ++last;
            if (last - first <= best) continue;
            best = static_cast<std::uint32_t>(last - first);
            side_[t] = own[first];
        }
        const std::uint32_t stray = all - best;
        sides_.mixed[t] = stray >= kMixed_px && stray >= kMixedShare * static_cast<double>(all);
    }
    anchors_[t] = side_[t] == kNone ? middle_pixel(view_, lattice, t) : side_[t];
    sides_.kept[t] = view_.disparity[anchors_[t]] > 0;
}

bool SideFinder::ruling(std::uint32_t i) const {
    return owner_[i] != kNone && piece_[i] == side_[owner_[i]];
}

// Pairs of neighbouring pixels across each edge say whether its two sides are one surface.
void SideFinder::vote(const SplitLattice& lattice, std::uint32_t t) {
    sides_.open[t] = {0, 0, 0};
    const auto& neighbours = lattice.neighbours[t];
    if (plain_[t] && areas_[t] > 0 && std::all_of(neighbours.begin(), neighbours.end(), [&](std::int32_t n) {
            return n < 0 || (plain_[n] && areas_[n] > 0);
        }))
        return;
    std::array<int, 3> votes{0, 0, 0}, pairs{0, 0, 0};
    each_own(view_, lattice, t, [&](int x, int y, std::uint32_t i) {
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
            const int u = x + dx, v = y + dy;
            if (u < 0 || v < 0 || u >= view_.width || v >= view_.height) continue;
            const std::uint32_t j = static_cast<std::uint32_t>(view_.index(u, v));
            const std::uint32_t other = owner_[j];
            if (other == t || other == kNone) continue;
            const bool both = ruling(i) && ruling(j), parted = jump(x, y, dx, dy);
            // without a jump to the lesser part, the one's surface goes on beyond the edge
            if (!both && (parted || !(ruling(i) || ruling(j)))) continue;
            for (int k = 0; k < 3; ++k) {
                if (neighbours[k] != static_cast<std::int32_t>(other)) continue;
                votes[k] += both && !parted ? -1 : 1;
                ++pairs[k];
            }
        }
    });
    for (int k = 0; k < 3; ++k) {
        if (neighbours[k] < 0) continue;
        sides_.open[t][k] =
            pairs[k] > 0 ? votes[k] > 0 : differ(t, static_cast<std::uint32_t>(neighbours[k]));
    }
}

// Without pixels along the edge: whether the triangles' own pixels are too different for their distance.
bool SideFinder::differ(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t i = anchors_[a], j = anchors_[b], w = static_cast<std::uint32_t>(view_.width);
    const auto apart = [](std::uint32_t p, std::uint32_t q) {
        return static_cast<float>(p > q ? p - q : q - p);
    };
    const float distance = std::max(apart(i % w, j % w), apart(i / w, j / w));
    return step::is_jump(view_.disparity[i], view_.disparity[j], jump_px_ + distance);
}

void SideFinder::collect_pixels(const SplitLattice& lattice) {
    const std::size_t count = lattice.triangles.size();
    const auto fitted = [&](std::uint32_t t, std::uint32_t i) {
        return piece_[i] == side_[t] && (view_.flags[i] & step::kTrusted);
    };
    sides_.starts.assign(count + 1, 0);
    each_triangle(lattice, [&](std::uint32_t t) {
        if (!sides_.kept[t]) return;
        each_own(view_, lattice, t, [&](int, int, std::uint32_t i) { sides_.starts[t + 1] += fitted(t, i); });
    });
    std::partial_sum(sides_.starts.begin(), sides_.starts.end(), sides_.starts.begin());
    sides_.pixels.resize(sides_.starts.back());
    each_triangle(lattice, [&](std::uint32_t t) {
        if (!sides_.kept[t]) return;
        std::uint32_t next = sides_.starts[t];
        each_own(view_, lattice, t, [&](int, int, std::uint32_t i) {
            if (fitted(t, i)) sides_.pixels[next++] = i;
        });
    });
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
