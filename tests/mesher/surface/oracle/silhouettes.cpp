// The course of silhouettes between the pixels, and their crossings with straight paths. All of it is in
// floats, with each sum in the given order, because the moves of vertices depend on the last bit.
#include <algorithm>
#include <cmath>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

struct Pixel {
    int x, y;
};

int pixel_at(float place, float by_px) {
    const float own = std::floor(place);
    return static_cast<int>(own + std::floor((place - own) + by_px));
}

// Returns the pixels of a path, at steps of at most half a pixel.
std::vector<Pixel> pixels_between(const Surfaces& s, const Vec2f& a, const Vec2f& b) {
    const float dx = b.x - a.x, dy = b.y - a.y;
    const int steps = static_cast<int>(2 * std::sqrt(dx * dx + dy * dy)) + 1;
    std::vector<Pixel> pixels;
    for (int k = 0; k <= steps; ++k) {
        const float t = static_cast<float>(k) / static_cast<float>(steps);
        pixels.push_back({std::clamp(pixel_at(a.x, t * dx), 0, s.width - 1),
                          std::clamp(pixel_at(a.y, t * dy), 0, s.height - 1)});
    }
    return pixels;
}

float length_between(const Vec2f& a, const Vec2f& b) {
    return std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
}

// Returns the share at which a -> b meets the line; if they run side by side, that of the path's point
// nearest to the line's point.
float meet(const SilhouetteLine& line, const Vec2f& a, const Vec2f& b) {
    const float dx = b.x - a.x, dy = b.y - a.y, length2 = dx * dx + dy * dy;
    const float along = dx * line.nx + dy * line.ny;
    const bool meets = along * along > 0.1f * length2;
    const float share = meets ? ((line.x - a.x) * line.nx + (line.y - a.y) * line.ny) / along
                              : ((line.x - a.x) * dx + (line.y - a.y) * dy) / length2;
    return std::clamp(share, 0.0f, 1.0f);
}

bool is_first_nearer(const Surfaces& s, const CrackEdge& c) {
    return s.first(c) > s.second(c);
}

// Crack edges that face the other way belong to another silhouette.
bool is_same_silhouette(const Surfaces& s, const CrackEdge& own, const CrackEdge& other) {
    return own.down != other.down || is_first_nearer(s, own) == is_first_nearer(s, other);
}

}  // namespace

float moved(float place, double by_px) {
    return place + std::round(static_cast<float>(by_px) * 1024) / 1024;
}

Vec2f between(const Vec2f& a, const Vec2f& b, float share) {
    return {moved(a.x, share * (b.x - a.x)), moved(a.y, share * (b.y - a.y))};
}

std::vector<CrackEdge> discontinuities_between(const Surfaces& s, const Vec2f& a, const Vec2f& b) {
    const std::vector<Pixel> way = pixels_between(s, a, b);
    std::vector<CrackEdge> found;
    const auto step_over = [&](const CrackEdge& c) {
        if (s.has(c)) found.push_back(c);
    };
    for (std::size_t k = 1; k < way.size(); ++k) {
        const Pixel from = way[k - 1], to = way[k];  // sideways first, then up or down
        if (from.x != to.x) step_over({std::min(from.x, to.x), from.y, false});
        if (from.y != to.y) step_over({to.x, std::min(from.y, to.y), true});
    }
    return found;
}

SilhouetteLine silhouette_line(const Surfaces& s, const CrackEdge& c) {
    const Vec2f own = s.middle(c);
    float weight = 0, x = 0, y = 0, nx = 0, ny = 0;
    for (int v = c.y - 2; v <= c.y + 2; ++v)
        for (int u = c.x - 2; u <= c.x + 2; ++u)
            for (const bool down : {false, true}) {
                const CrackEdge other{u, v, down};
                if (!s.has(other) || !is_same_silhouette(s, c, other)) continue;
                const Vec2f middle = s.middle(other);
                const float ox = middle.x - own.x, oy = middle.y - own.y;
                const float r = 1 - (ox * ox + oy * oy) / (2.75f * 2.75f);
                if (!(r > 0)) continue;
                const float w = r * r, towards = is_first_nearer(s, other) ? -w : w;
                weight += w;
                x += w * ox;
                y += w * oy;
                (down ? ny : nx) += towards;
            }
    const float length = std::sqrt(nx * nx + ny * ny);
    if (!(length > 0.1f * weight)) {
        const float towards = is_first_nearer(s, c) ? -1.0f : 1.0f;
        return {own.x, own.y, c.down ? 0.0f : towards, c.down ? towards : 0.0f};
    }
    const float ux = nx / length, uy = ny / length, off = (x * ux + y * uy) / weight;
    return {moved(own.x, off * ux), moved(own.y, off * uy), ux, uy};
}

// Returns an edge's crossing. a_on, b_on: true if that end lies on a silhouette already; forth: true if
// the edge's pixels are walked over from a to b. From an end on a silhouette the farthest discontinuity
// counts, else the nearest.
float edge_crossing(const Surfaces& s, const Vec2f& a, bool a_on, const Vec2f& b, bool b_on, bool forth) {
    if (a_on && b_on) return -1;
    const std::vector<CrackEdge> met = discontinuities_between(s, forth ? a : b, forth ? b : a);
    if (met.empty()) return -1;
    const float share = meet(silhouette_line(s, a_on == forth ? met.back() : met.front()), a, b);
    const float slack = 0.3f;  // a nearer one is the end's own silhouette
    if (a_on && !(share > slack)) return -1;
    if (b_on && share > 1 - slack) return -1;
    return share;
}

// Returns, for the first discontinuities from the midpoint to a and to b, the crossing
// nearer to the midpoint.
float crossing_near_middle(const Surfaces& s, const Vec2f& a, const Vec2f& b) {
    const Vec2f middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
    const auto towards = [&](const Vec2f& end) {
        const std::vector<CrackEdge> met = discontinuities_between(s, middle, end);
        return met.empty() ? -1 : meet(silhouette_line(s, met.front()), a, b);
    };
    const float back = towards(a), forth = towards(b);
    if (back < 0 || forth < 0) return std::max(back, forth);
    return std::fabs(forth - 0.5f) < std::fabs(back - 0.5f) ? forth : back;
}

// Returns a point on the line through the crack edge nearest to p, the first of equal ones row by row, if one
// is at most half a pixel farther away than the crossing; else the crossing.
Vec2f nearest_silhouette_point(const Surfaces& s, const Vec2f& p, const Vec2f& crossing) {
    const float reach = length_between(p, crossing) + 0.5f;
    const int window = static_cast<int>(reach) + 1, px = static_cast<int>(p.x), py = static_cast<int>(p.y);
    float least2 = reach * reach;
    CrackEdge nearest{-1, -1, false};
    for (int y = py - window; y <= py + window; ++y)
        for (int x = px - window; x <= px + window; ++x)
            for (const bool down : {false, true}) {
                if (!s.has({x, y, down})) continue;
                const Vec2f middle = s.middle({x, y, down});
                const float dx = middle.x - p.x, dy = middle.y - p.y, distance2 = dx * dx + dy * dy;
                if (distance2 < least2) least2 = distance2, nearest = {x, y, down};
            }
    if (nearest.x < 0) return crossing;
    const SilhouetteLine line = silhouette_line(s, nearest);
    const float along = (p.y - line.y) * line.nx - (p.x - line.x) * line.ny;
    const float kept = std::clamp(along, -0.75f, 0.75f);
    return {moved(line.x, -kept * line.ny), moved(line.y, kept * line.nx)};
}

}  // namespace hexrelief::surface::oracle
