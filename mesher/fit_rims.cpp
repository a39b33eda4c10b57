#include <algorithm>
#include <array>
#include <cmath>

#include "mesher/buckets.h"
#include "mesher/sheet_parts.h"
#include "mesher/steps/rim.h"

namespace hexrelief {
namespace {

constexpr int kRounds = 5;
constexpr float kReach_px = 1.5f;       // of an edge for the pixel sides that it is fitted to
constexpr float kMargin_px = 0.05f;     // between an edge and the centres of the pixels along it
constexpr float kUrgency = 2;           // of pixel sides where it is not kept
constexpr float kStay_px = 1.0f;        // vertices move less mostly: the sides around are found once
constexpr float kLeastMove_px = 0.03f;  // of a vertex: less changes nothing but the triangles to look at
constexpr float kMostMove_px = 1.0f;    // of a vertex in a round
// Where a low step falls to the right, the rim lies so far inside of the near surface: what the other camera
// sees beyond is only a few pixels wide, and an error of the rim would hide it.
constexpr float kLowInset_px = 0.2f;
constexpr float kLowStep_px = 3.5f;
constexpr double kPull = 0.3;        // towards staying, in pixel sides
constexpr double kLeastShape = 0.2;  // of a triangle, unless it was worse before

struct Equation {
    double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
};

double shape(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const double abx = double(b.x) - a.x, aby = double(b.y) - a.y, acx = double(c.x) - a.x,
                 acy = double(c.y) - a.y, bcx = acx - abx, bcy = acy - aby;
    const double sum = abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy;
    return sum > 0 ? 3.4641016151377544 * (abx * acy - aby * acx) / sum : 0;
}

// Whether the surface behind a step can be seen by the other camera alone for no more than about its pixel.
bool is_low_fall(const step::PixelView& view, const step::Crack& c) {
    if (c.down) return false;
    const float* d = view.disparity + view.index(c.x, c.y);
    return d[1] > 0 && d[0] > d[1] && d[0] - d[1] < kLowStep_px;
}

// Sides of pixels that jumps lie on: their middles, and towards the nearer pixel 1 or -1 along one of the
// axes.
struct PixelSides {
    std::vector<float> x, y, near_x, near_y;

    void add(const step::PixelView& view, const step::Crack& c, const step::Middle& middle) {
        const float towards = step::near_is_first(view, c) ? -1.0f : 1.0f;
        x.push_back(middle.x - (is_low_fall(view, c) ? kLowInset_px : 0));
        y.push_back(middle.y);
        near_x.push_back(c.down ? 0.0f : towards);
        near_y.push_back(c.down ? towards : 0.0f);
    }
};

// One of them as the edge along it sees it.
struct Pull {
    float share, residual;  // of the way along the edge; px from it
    float weight, across;   // across: how squarely the near surface is on the left, -1 .. 1
};

// An edge from (x, y), with its squared length and its unit normal, which is on the left.
struct EdgeFrame {
    float x, y, dx, dy, size2, nx, ny;
};

// Writes what the edge sees of sides from `first` on; weight 0: beyond its reach.
#if defined(__x86_64__)
__attribute__((target_clones("avx512f", "avx2", "default")))
#endif
void see(const EdgeFrame& edge, const PixelSides& sides, std::size_t first, std::size_t count, Pull* pulls) {
    const EdgeFrame e = edge;
    const float *x = sides.x.data() + first, *y = sides.y.data() + first;
    const float *near_x = sides.near_x.data() + first, *near_y = sides.near_y.data() + first;
#pragma GCC ivdep
    for (std::size_t i = 0; i < count; ++i) {
        const float mx = x[i] - e.x, my = y[i] - e.y;
        const float s = (mx * e.dx + my * e.dy) / e.size2, r = mx * e.nx + my * e.ny;
        const float across = near_x[i] * e.nx + near_y[i] * e.ny;
        const float away = r / kReach_px, squarely = std::fabs(across);
        // beyond, the edge has one of the side's two pixels on the wrong side, or nearly so
        const float urgency = std::fabs(r) > 0.5f * squarely - kMargin_px ? kUrgency : 1.0f;
        const float w = (1 - away * away) * squarely * urgency;
        const bool within = (s >= 0) & (s <= 1) & (r <= kReach_px) & (r >= -kReach_px);
        pulls[i] = {s, r, within ? w : 0.0f, across};
    }
}

// Items of a thread's list.
struct Items {
    std::size_t first = 0, end = 0;
};

struct RimEdge {
    std::uint32_t a = 0, b = 0;
    float nx = 0, ny = 0;      // unit, to the left
    int thread = -1;           // whose list holds its sides
    Vec2f from_a{}, from_b{};  // where its vertices were when its sides were found
    Items sides{};
    std::array<double, 2> weights{}, residuals{};  // sums of the pulls on either vertex; residuals weighted
};

class RimFitter {
  public:
    RimFitter(const PixelSurfaces& surfaces, const TriangleSides& sides, SplitLattice& lattice, Team& team)
        : view_(surfaces.view()), sides_(sides), lattice_(lattice), team_(team), lists_(team.size()) {}

    void run() {
        find_rims();
        find_triangles();
        moved_.assign(vertices_.size(), 1);
        for (int round = 0; round < kRounds; ++round) {
            team_.run([&](int thread) {
                const std::size_t end = team_.share(edges_.size(), thread + 1);
                for (std::size_t e = team_.share(edges_.size(), thread); e < end; ++e)
                    if (has_moved(edges_[e])) find_pulls(edges_[e], thread);
                team_.barrier();
                const std::size_t last = team_.share(vertices_.size(), thread + 1);
                for (std::size_t i = team_.share(vertices_.size(), thread); i < last; ++i)
                    if (has_moved_around(i)) steps_[i] = best_step(i);
            });
            for (std::size_t i = 0; i < vertices_.size(); ++i) moved_[i] = move(i);
        }
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    struct Step {
        double x, y;
    };

    bool has_moved(const RimEdge& edge) const { return moved_[place_[edge.a]] || moved_[place_[edge.b]]; }
    bool has_moved_around(std::size_t i) const {
        const auto ends = ends_[i];
        return std::any_of(ends.begin(), ends.end(),
                           [&](std::uint32_t end) { return has_moved(edges_[end / 2]); });
    }
    bool kept(std::int32_t t) const { return t >= 0 && sides_.kept[t]; }
    void find_rims() {
        place_.assign(lattice_.points.size(), kNone);
        for (std::uint32_t t = 0; t < lattice_.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const std::int32_t n = lattice_.neighbours[t][k];
                if (n < static_cast<std::int32_t>(t)) continue;  // each once; none at the image's border
                if (!(kept(static_cast<std::int32_t>(t)) || kept(n))) continue;
                if (kept(static_cast<std::int32_t>(t)) == kept(n) && !sides_.open[t][k]) continue;
                const std::uint32_t a = lattice_.triangles[t][k], b = lattice_.triangles[t][(k + 1) % 3];
                edges_.push_back({.a = a, .b = b});
                place_[a] = place_[b] = 0;
            }
        for (std::uint32_t v = 0; v < place_.size(); ++v) {
            if (place_[v] == kNone) continue;
            place_[v] = static_cast<std::uint32_t>(vertices_.size());
            vertices_.push_back(v);
        }
        steps_.resize(vertices_.size());
        ends_ = sort_into(vertices_.size(), [&](const auto& put) {
            for (std::uint32_t e = 0; e < edges_.size(); ++e)
                put(place_[edges_[e].a], 2 * e), put(place_[edges_[e].b], 2 * e + 1);
        });
    }
    void find_triangles() {
        triangles_ = sort_into(vertices_.size(), [&](const auto& put) {
            for (std::uint32_t t = 0; t < lattice_.triangles.size(); ++t)
                for (const std::uint32_t v : lattice_.triangles[t])
                    if (place_[v] != kNone) put(place_[v], t);
        });
    }
    // All sides near an edge, and as far around as its vertices may move before they are found anew.
    void find_sides(RimEdge& edge, PixelSides& sides) const {
        const Vec2f &p = lattice_.points[edge.a], &q = lattice_.points[edge.b];
        edge.from_a = p;
        edge.from_b = q;
        edge.sides.first = sides.x.size();
        constexpr float kAround_px = kReach_px + kStay_px;
        const auto low = [](float u, float v) {
            return std::max(0, static_cast<int>(std::min(u, v) - kAround_px) - 1);
        };
        const auto high = [](float u, float v, int last) {
            return std::min(last, static_cast<int>(std::max(u, v) + kAround_px) + 1);
        };
        const int x0 = low(p.x, q.x), x1 = high(p.x, q.x, view_.width - 1);
        const int y0 = low(p.y, q.y), y1 = high(p.y, q.y, view_.height - 1);
        const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
        const float most =
            (kAround_px + 0.01f) * (kAround_px + 0.01f) * size2;  // 0.01: more than rounding may do
        for (int y = y0; y <= y1; ++y) {
            const std::uint8_t* row = view_.flags + view_.index(0, y);
            for (int x = x0; x <= x1; ++x) {
                if (!(row[x] & (step::kJumpRight | step::kJumpDown))) continue;
                for (int down = 0; down < 2; ++down) {
                    if (!(row[x] & (down ? step::kJumpDown : step::kJumpRight))) continue;
                    const step::Crack c{x, y, down};
                    const step::Middle middle = step::crack_middle(view_, c);
                    const float off = (middle.y - p.y) * dx - (middle.x - p.x) * dy;
                    if (off * off <= most) sides.add(view_, c, middle);
                }
            }
        }
        edge.sides.end = sides.x.size();
    }
    bool has_left(const Vec2f& from, std::uint32_t v) const {
        const Vec2f& p = lattice_.points[v];
        const float dx = p.x - from.x, dy = p.y - from.y;
        return dx * dx + dy * dy > kStay_px * kStay_px;
    }
    // The jumps along an edge that face as it does: the side with more of the near surface is theirs as well.
    void find_pulls(RimEdge& edge, int thread) {
        auto& [sides, seen] = lists_[thread];
        if (edge.thread < 0 || has_left(edge.from_a, edge.a) || has_left(edge.from_b, edge.b))
            find_sides(edge, sides);
        edge.thread = thread;
        edge.weights = edge.residuals = {0, 0};
        const Vec2f &p = lattice_.points[edge.a], &q = lattice_.points[edge.b];
        const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
        if (!(size2 > 0)) return;
        const float size = std::sqrt(size2), nx = -dy / size, ny = dx / size;
        edge.nx = nx;
        edge.ny = ny;
        const std::size_t count = edge.sides.end - edge.sides.first;
        if (seen.size() < count) seen.resize(count);
        see({p.x, p.y, dx, dy, size2, nx, ny}, sides, edge.sides.first, count, seen.data());
        double facing = 0;
        for (std::size_t i = 0; i < count; ++i) facing += seen[i].weight * seen[i].across;
        for (std::size_t i = 0; i < count; ++i) {
            const Pull& pull = seen[i];
            const double weight = pull.across * facing > 0 ? pull.weight : 0;
            const double weights[2] = {weight * (1 - pull.share), weight * pull.share};
            for (int end = 0; end < 2; ++end) {
                edge.weights[end] += weights[end];
                edge.residuals[end] += weights[end] * pull.residual;
            }
        }
    }
    // Of the i-th rim vertex, from the edges at it.
    Step best_step(std::size_t i) const {
        Equation e;
        for (const std::uint32_t end : ends_[i]) {
            const RimEdge& edge = edges_[end / 2];
            add(e, edge.nx, edge.ny, edge.weights[end % 2], edge.residuals[end % 2]);
        }
        e.xx += kPull;
        e.yy += kPull;
        const double determinant = e.xx * e.yy - e.xy * e.xy;
        double ux = (e.x * e.yy - e.y * e.xy) / determinant, uy = (e.y * e.xx - e.x * e.xy) / determinant;
        const double size = std::sqrt(ux * ux + uy * uy);
        if (size > kMostMove_px) ux *= kMostMove_px / size, uy *= kMostMove_px / size;
        return {ux, uy};
    }
    static void add(Equation& e, double nx, double ny, double weight, double residual) {
        e.xx += weight * nx * nx;
        e.xy += weight * nx * ny;
        e.yy += weight * ny * ny;
        e.x += residual * nx;
        e.y += residual * ny;
    }
    // Returns whether it did. One vertex after the other, because a move is judged by where the neighbours
    // are by then.
    bool move(std::size_t i) {
        if (steps_[i].x * steps_[i].x + steps_[i].y * steps_[i].y < kLeastMove_px * kLeastMove_px)
            return false;
        Vec2f& p = lattice_.points[vertices_[i]];
        const Vec2f from = p;
        const float w = static_cast<float>(view_.width), h = static_cast<float>(view_.height);
        const double ux = p.x <= 0 || p.x >= w ? 0 : steps_[i].x, uy = p.y <= 0 || p.y >= h ? 0 : steps_[i].y;
        const Vec2f to{step::clamp_to(static_cast<float>(from.x + ux), 0.0f, w),
                       step::clamp_to(static_cast<float>(from.y + uy), 0.0f, h)};
        if (to == from) return false;
        p = to;
        const double after = worst_shape(i);
        if (!(after >= kLeastShape)) {
            p = from;
            if (!(after >= worst_shape(i))) return false;
            p = to;
        }
        for (const std::uint32_t t : triangles_[i])
            lattice_.changed[t] = std::max<std::uint8_t>(lattice_.changed[t], SplitLattice::kMoved);
        return true;
    }
    double worst_shape(std::size_t i) const {
        double worst = 1;
        for (const std::uint32_t k : triangles_[i]) {
            const Triangle& t = lattice_.triangles[k];
            worst =
                std::min(worst, shape(lattice_.points[t[0]], lattice_.points[t[1]], lattice_.points[t[2]]));
        }
        return worst;
    }

    step::PixelView view_;
    const TriangleSides& sides_;
    SplitLattice& lattice_;
    Team& team_;
    std::vector<RimEdge> edges_;
    std::vector<std::uint32_t> vertices_, place_;  // on rims, ascending; a vertex: where it is among them
    Buckets ends_, triangles_;                     // at each rim vertex; ends: 2 * edge + which
    struct Lists {
        PixelSides sides;
        std::vector<Pull> seen;  // of one edge
    };
    std::vector<Lists> lists_;  // of a thread's edges
    std::vector<Step> steps_;
    std::vector<std::uint8_t> moved_;  // rim vertices: in the round before
};

}  // namespace

void fit_rims(const PixelSurfaces& surfaces, const TriangleSides& sides, SplitLattice& lattice, Team& team) {
    RimFitter(surfaces, sides, lattice, team).run();
}

}  // namespace hexrelief
