#include <algorithm>
#include <cmath>

#include "mesher/sheet_parts.h"
#include "mesher/steps/rim.h"

namespace hexrelief {
namespace {

constexpr int kRounds = 3;
constexpr float kReach_px = 2.5f;     // of an edge for the pixel sides that it is fitted to
constexpr float kMostMove_px = 1.0f;  // of a vertex in a round
constexpr double kPull = 0.3;         // towards staying, in pixel sides
constexpr double kLeastShape = 0.2;   // of a triangle, unless it was worse before

struct Equation {
    double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
};

double shape(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const double abx = double(b.x) - a.x, aby = double(b.y) - a.y, acx = double(c.x) - a.x,
                 acy = double(c.y) - a.y, bcx = acx - abx, bcy = acy - aby;
    const double sum = abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy;
    return sum > 0 ? 3.4641016151377544 * (abx * acy - aby * acx) / sum : 0;
}

class RimFitter {
  public:
    RimFitter(const PixelSurfaces& surfaces, SplitLattice& lattice, const TriangleSides& sides)
        : view_(surfaces.view()), lattice_(lattice), sides_(sides) {}

    void run() {
        find_rims();
        find_corners();
        for (int round = 0; round < kRounds; ++round) {
            equations_.assign(lattice_.points.size(), {});
            for (const auto& [a, b] : rims_) add_edge(a, b);
            for (const std::uint32_t v : vertices_) move(v);
        }
    }

  private:
    bool kept(std::int32_t t) const { return t >= 0 && sides_.kept[t]; }
    void find_rims() {
        std::vector<std::uint8_t> on(lattice_.points.size(), 0);
        for (std::uint32_t t = 0; t < lattice_.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const std::int32_t n = lattice_.neighbours[t][k];
                if (n < static_cast<std::int32_t>(t)) continue;  // each once; none at the image's border
                if (!(kept(static_cast<std::int32_t>(t)) || kept(n))) continue;
                if (kept(static_cast<std::int32_t>(t)) == kept(n) && !sides_.open[t][k]) continue;
                const std::uint32_t a = lattice_.triangles[t][k], b = lattice_.triangles[t][(k + 1) % 3];
                rims_.emplace_back(a, b);
                on[a] = on[b] = 1;
            }
        for (std::uint32_t v = 0; v < on.size(); ++v)
            if (on[v]) vertices_.push_back(v);
    }
    void find_corners() {
        starts_.assign(lattice_.points.size() + 1, 0);
        for (const Triangle& t : lattice_.triangles)
            for (const std::uint32_t v : t) ++starts_[v + 1];
        for (std::size_t v = 1; v < starts_.size(); ++v) starts_[v] += starts_[v - 1];
        triangles_.resize(starts_.back());
        std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
        for (std::uint32_t t = 0; t < lattice_.triangles.size(); ++t)
            for (const std::uint32_t v : lattice_.triangles[t]) triangles_[next[v]++] = t;
    }
    void add_edge(std::uint32_t a, std::uint32_t b) {
        const Vec2f &p = lattice_.points[a], &q = lattice_.points[b];
        const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
        if (!(size2 > 0)) return;
        const float size = std::sqrt(size2), nx = -dy / size, ny = dx / size;
        const auto low = [](float u, float v) { return static_cast<int>(std::min(u, v) - kReach_px) - 1; };
        const auto high = [](float u, float v) { return static_cast<int>(std::max(u, v) + kReach_px) + 1; };
        // The rim's facing: the side with more of the near surface, by the pixel sides themselves.
        double facing = 0;
        for (int pass = 0; pass < 2; ++pass)
            for (int y = low(p.y, q.y); y <= high(p.y, q.y); ++y)
                for (int x = low(p.x, q.x); x <= high(p.x, q.x); ++x)
                    for (int down = 0; down < 2; ++down) {
                        const step::Crack c{x, y, down};
                        if (!step::has_crack(view_, c)) continue;
                        const step::Middle middle = step::crack_middle(view_, c);
                        const float mx = middle.x - p.x, my = middle.y - p.y;
                        const float s = (mx * dx + my * dy) / size2, r = mx * nx + my * ny;
                        if (s < 0 || s > 1 || r > kReach_px || r < -kReach_px) continue;
                        const float across =
                            (down ? ny : nx) * (step::near_is_first(view_, c) ? -1.0f : 1.0f);
                        const float away = r / kReach_px, w = (1 - away * away) * std::fabs(across);
                        if (pass == 0) {
                            facing += w * across;
                            continue;
                        }
                        if (across * facing <= 0) continue;
                        add(equations_[a], nx, ny, 1 - s, r, w);
                        add(equations_[b], nx, ny, s, r, w);
                    }
    }
    static void add(Equation& e, float nx, float ny, float share, float residual, float weight) {
        const double w = double(weight) * share;
        e.xx += w * nx * nx;
        e.xy += w * nx * ny;
        e.yy += w * ny * ny;
        e.x += w * nx * residual;
        e.y += w * ny * residual;
    }
    void move(std::uint32_t v) {
        Equation e = equations_[v];
        e.xx += kPull;
        e.yy += kPull;
        const double determinant = e.xx * e.yy - e.xy * e.xy;
        double ux = (e.x * e.yy - e.y * e.xy) / determinant, uy = (e.y * e.xx - e.x * e.xy) / determinant;
        const double size = std::sqrt(ux * ux + uy * uy);
        if (size > kMostMove_px) ux *= kMostMove_px / size, uy *= kMostMove_px / size;
        Vec2f& p = lattice_.points[v];
        const Vec2f from = p;
        const float w = static_cast<float>(view_.width), h = static_cast<float>(view_.height);
        if (p.x <= 0 || p.x >= w) ux = 0;
        if (p.y <= 0 || p.y >= h) uy = 0;
        const double before = worst_shape(v);
        p = {step::clamp_to(static_cast<float>(from.x + ux), 0.0f, w),
             step::clamp_to(static_cast<float>(from.y + uy), 0.0f, h)};
        if (!(worst_shape(v) >= std::min(kLeastShape, before))) p = from;
        if (p == from) return;
        for (std::uint32_t i = starts_[v]; i < starts_[v + 1]; ++i) lattice_.changed[triangles_[i]] = 1;
    }
    double worst_shape(std::uint32_t v) const {
        double worst = 1;
        for (std::uint32_t i = starts_[v]; i < starts_[v + 1]; ++i) {
            const Triangle& t = lattice_.triangles[triangles_[i]];
            worst =
                std::min(worst, shape(lattice_.points[t[0]], lattice_.points[t[1]], lattice_.points[t[2]]));
        }
        return worst;
    }

    step::PixelView view_;
    SplitLattice& lattice_;
    const TriangleSides& sides_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> rims_;
    std::vector<std::uint32_t> vertices_, starts_, triangles_;  // on rims; triangles at each vertex
    std::vector<Equation> equations_;
};

}  // namespace

void fit_rims(const PixelSurfaces& surfaces, const TriangleSides& sides, SplitLattice& lattice) {
    RimFitter(surfaces, lattice, sides).run();
}

}  // namespace hexrelief
