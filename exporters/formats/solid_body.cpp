#include "exporters/formats/solid_body.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

#include "exporters/formats/bridge_holes.h"
#include "pipeline/data/union_find.h"

namespace hexrelief::exporters {
namespace {

using Index = std::uint32_t;

constexpr double kFarthestShare = 0.001;  // of the vertices, which noise may have put anywhere
constexpr double kFootShare = 0.01;       // of a shell's vertices: what it stands on while it is printed
constexpr double kMostOfDepth = 0.5;      // that the base may be thick

double depth_of(const Vec3f& p) {
    return -static_cast<double>(p.z);
}

// Returns the depth that the farthest vertices of the body get.
double farthest(const std::vector<Vec3f>& positions, SolidKind kind) {
    std::vector<double> depths;
    for (const Vec3f& p : positions) depths.push_back(depth_of(p));
    const double share = kind == SolidKind::shell ? kFootShare : kFarthestShare;
    const auto at = static_cast<std::ptrdiff_t>((1 - share) * static_cast<double>(depths.size() - 1));
    std::ranges::nth_element(depths, depths.begin() + at);
    return depths[static_cast<std::size_t>(at)];
}

// Returns the larger side of what all rays cover at a depth of 1.
double extent(const std::vector<Vec3f>& positions) {
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (const Vec3f& p : positions)
        for (int k = 0; k < 2; ++k) {
            const double at = (k == 0 ? p.x : p.y) / depth_of(p);
            low[k] = std::min(low[k], at);
            high[k] = std::max(high[k], at);
        }
    return std::max(high[0] - low[0], high[1] - low[1]);
}

// A vertex lies on the ray of a point of the image; several do where a cut has parted them. Rays and the
// vertices of each are numbered by position.
struct Front {
    std::vector<Vec3f> positions;        // depths are those of the body
    std::vector<Vec2f> texcoords;        // empty if the surface has none
    std::vector<Index> rays;             // of each vertex
    std::vector<Vec2f> points;           // of each ray
    std::vector<std::vector<Index>> on;  // a ray's vertices, nearest first
    std::vector<Triangle> triangles;
};

Front front_of(const SurfaceMesh& surface, SolidKind kind) {
    const auto count = static_cast<std::ptrdiff_t>(surface.left_vertices());
    std::vector<Vec3f> positions(surface.positions.begin(), surface.positions.begin() + count);
    const double far = farthest(positions, kind);
    for (Vec3f& p : positions)
        if (const double shrink = far / depth_of(p); shrink < 1)
            p = {static_cast<float>(p.x * shrink), static_cast<float>(p.y * shrink),
                 static_cast<float>(-far)};
    std::vector<Index> order(positions.size()), names(positions.size());
    std::iota(order.begin(), order.end(), Index{0});
    const auto key = [&](Index i) {
        const Vec2f& point = surface.image_points[i];
        return std::tuple(point.y, point.x, depth_of(positions[i]), i);
    };
    std::ranges::sort(order, {}, key);
    Front front;
    for (const Index i : order) {
        const Vec2f& point = surface.image_points[i];
        if (front.points.empty() || !(front.points.back() == point)) {
            front.points.push_back(point);
            front.on.emplace_back();
        }
        // Vertices at one place are one.
        if (front.on.back().empty() || front.positions.back().z != positions[i].z) {
            front.on.back().push_back(static_cast<Index>(front.positions.size()));
            front.positions.push_back(positions[i]);
            if (!surface.texcoords.empty()) front.texcoords.push_back(surface.texcoords[i]);
            front.rays.push_back(static_cast<Index>(front.points.size() - 1));
        }
        names[i] = static_cast<Index>(front.positions.size() - 1);
    }
    for (std::size_t i = 0; i < surface.left_triangles(); ++i) {
        const Triangle& t = surface.triangles[i];
        const Triangle named{names[t[0]], names[t[1]], names[t[2]]};
        const auto ray = [&](std::size_t k) { return front.rays[named[k]]; };
        if (ray(0) != ray(1) && ray(1) != ray(2) && ray(2) != ray(0)) front.triangles.push_back(named);
    }
    return front;
}

// Twice the area in the image, px^2.
double area_of(const Front& front, const Triangle& t) {
    const Vec2f &a = front.points[front.rays[t[0]]], &b = front.points[front.rays[t[1]]],
                &c = front.points[front.rays[t[2]]];
    return std::abs(double(b.x - a.x) * (c.y - a.y) - double(c.x - a.x) * (b.y - a.y));
}

// Removes pieces of the image that are smaller than `least`.
void drop_crumbs(Front& front, double least) {
    UnionFind pieces(front.points.size());
    for (const Triangle& t : front.triangles)
        for (const Index other : {t[1], t[2]}) pieces.join(front.rays[t[0]], front.rays[other]);
    std::vector<double> areas(front.points.size());
    const auto piece = [&](const Triangle& t) { return pieces.find(front.rays[t[0]]); };
    for (const Triangle& t : front.triangles) areas[piece(t)] += area_of(front, t);
    std::erase_if(front.triangles, [&](const Triangle& t) { return areas[piece(t)] < least; });
}

// A side of a triangle, or of the base, in the direction that a wall's triangle has it.
struct Side {
    Index first, second;  // rays, first < second
    bool is_forwards;     // from first to second
    Index at_first, at_second;

    auto key() const { return std::tuple(first, second, is_forwards, at_first, at_second); }
};

// Adds walls between the sides of the front that lie over each other in the image, and to the base.
class Walls {
  public:
    // base: the base's vertex on each ray.
    Walls(const Front& front, const std::vector<Index>& base, std::vector<Triangle>& triangles)
        : front_(front), base_(base), triangles_(triangles) {}

    void add_all() {
        std::vector<Side> sides;
        for (const Triangle& t : front_.triangles)
            for (std::size_t k = 0; k < 3; ++k) sides.push_back(side_between(t[(k + 1) % 3], t[k]));
        std::ranges::sort(sides, {}, &Side::key);
        for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
            while (end < sides.size() && sides[end].first == sides[begin].first &&
                   sides[end].second == sides[begin].second)
                ++end;
            add_between(&sides[begin], end - begin);
        }
    }

  private:
    Side side_between(Index from, Index to) const {
        const Index a = front_.rays[from], b = front_.rays[to];
        return a < b ? Side{a, b, true, from, to} : Side{b, a, false, to, from};
    }

    // Joins the sides over one line of the image, those of one direction to those of the other.
    void add_between(const Side* sides, std::size_t count) {
        const Side* const forwards =
            std::partition_point(sides, sides + count, [](const Side& side) { return !side.is_forwards; });
        const std::size_t back = static_cast<std::size_t>(forwards - sides), forth = count - back;
        const Side base{sides->first, sides->second, true, base_[sides->first], base_[sides->second]};
        for (std::size_t i = 0; i < std::max(back, forth); ++i)
            add_wall(i < forth ? forwards[i] : base, i < back ? sides[i] : base);
    }

    // Fills what lies between two sides of one line, seen from where `forwards` goes from left to right.
    void add_wall(const Side& forwards, const Side& backwards) {
        const std::vector<Index> left = along(forwards.first, forwards.at_first, backwards.at_first),
                                 right = along(forwards.second, forwards.at_second, backwards.at_second);
        for (std::size_t i = 0; i + 1 < left.size(); ++i)
            triangles_.push_back({right[0], left[i + 1], left[i]});
        for (std::size_t i = 0; i + 1 < right.size(); ++i)
            triangles_.push_back({right[i], right[i + 1], left.back()});
    }

    // Returns the vertices of a ray from one to the other.
    std::vector<Index> along(Index ray, Index from, Index to) const {
        std::vector<Index> all = front_.on[ray];
        all.push_back(base_[ray]);
        auto a = std::ranges::find(all, from), b = std::ranges::find(all, to);
        if (a <= b) return {a, b + 1};
        std::vector<Index> back(b, a + 1);
        std::ranges::reverse(back);
        return back;
    }

    const Front& front_;
    const std::vector<Index>& base_;
    std::vector<Triangle>& triangles_;
};

// Places the front and the base, whose rays it has from the nearest vertex of each, in mm above the base.
std::vector<Vec3f> placed(const Front& front, double size_mm, SolidKind kind) {
    const double far = farthest(front.positions, kind), wide = extent(front.positions);
    const double thickness_mm = std::min(kLeastThickness_mm, size_mm / 20);
    // At the base one metre of depth is `scale` mm; the base is as far behind `far` as is thick enough.
    const double base = far / (1 - std::min(kMostOfDepth, thickness_mm * wide / size_mm));
    const double scale = size_mm / (wide * base);
    std::vector<Vec3f> positions;
    const auto add = [&](const Vec3f& p, double depth) {
        positions.push_back({static_cast<float>(p.x / depth_of(p) * depth * scale),
                             static_cast<float>(p.y / depth_of(p) * depth * scale),
                             static_cast<float>((base - depth) * scale)});
    };
    for (const Vec3f& p : front.positions) add(p, depth_of(p));
    for (const std::vector<Index>& vertices : front.on) {
        const double farthest_on_ray = depth_of(front.positions[vertices.back()]);
        add(front.positions[vertices[0]], kind == SolidKind::shell ? farthest_on_ray + (base - far) : base);
    }
    return positions;
}

// Returns those of the front and of the base, each of whose vertices has the nearest one's of its ray.
std::vector<Vec2f> texcoords_of(const Front& front) {
    std::vector<Vec2f> texcoords = front.texcoords;
    if (texcoords.empty()) return texcoords;
    for (const std::vector<Index>& vertices : front.on) texcoords.push_back(front.texcoords[vertices[0]]);
    return texcoords;
}

// Removes the vertices that no triangle has.
void drop_unused(SurfaceMesh& body) {
    constexpr Index kUnused = ~Index{0};
    std::vector<Index> names(body.positions.size(), kUnused);
    for (const Triangle& t : body.triangles)
        for (const Index i : t) names[i] = 0;
    std::vector<Vec3f> used;
    std::vector<Vec2f> texcoords;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == kUnused) continue;
        names[i] = static_cast<Index>(used.size());
        used.push_back(body.positions[i]);
        if (!body.texcoords.empty()) texcoords.push_back(body.texcoords[i]);
    }
    body.positions = std::move(used);
    body.texcoords = std::move(texcoords);
    for (Triangle& t : body.triangles)
        for (Index& i : t) i = names[i];
}

// Parts the edges that more than two triangles have, as where walls touch along a ray: each further pair of
// triangles gets a vertex on the edge. Returns false if a triangle has another such edge, which is left.
bool part_edges(SurfaceMesh& body) {
    struct Edge {
        Index low, high;
        bool is_forwards;
        std::size_t triangle;
        auto key() const { return std::tuple(low, high, is_forwards, triangle); }
    };
    std::vector<Edge> edges;
    for (std::size_t i = 0; i < body.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const Index from = body.triangles[i][k], to = body.triangles[i][(k + 1) % 3];
            edges.push_back({std::min(from, to), std::max(from, to), from < to, i});
        }
    std::ranges::sort(edges, {}, &Edge::key);
    std::vector<bool> is_split(body.triangles.size());
    bool is_done = true;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        const Index low = edges[begin].low, high = edges[begin].high;
        while (end < edges.size() && edges[end].low == low && edges[end].high == high) ++end;
        const std::size_t pairs = (end - begin) / 2;  // as many in one direction as in the other
        for (std::size_t pair = 1; pair < pairs; ++pair) {
            const std::size_t both[2] = {edges[begin + pair].triangle, edges[begin + pairs + pair].triangle};
            if (is_split[both[0]] || is_split[both[1]]) {
                is_done = false;
                continue;
            }
            const auto between = static_cast<Index>(body.positions.size());
            const float share = static_cast<float>(pair) / static_cast<float>(pairs);
            const auto mix = [&](float a, float b) { return a + (b - a) * share; };
            const Vec3f a = body.positions[low], b = body.positions[high];
            body.positions.push_back({mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z)});
            if (!body.texcoords.empty()) body.texcoords.push_back(body.texcoords[low]);
            for (const std::size_t i : both) {
                is_split[i] = true;
                Triangle other = body.triangles[i];
                std::ranges::replace(other, low, between);
                std::ranges::replace(body.triangles[i], high, between);
                body.triangles.push_back(other);
            }
        }
    }
    return is_done;
}

}  // namespace

SurfaceMesh solid_body(const SurfaceMesh& surface, double size_mm, SolidKind kind) {
    Front front = front_of(surface, kind);
    double area = 0;
    for (const Triangle& t : front.triangles) area += area_of(front, t);
    drop_crumbs(front, kCrumbShare * area);
    bridge_holes(front.triangles, front.rays, front.points, kBridgedShare * area);
    SurfaceMesh body;
    body.positions = placed(front, size_mm, kind);
    body.texcoords = texcoords_of(front);
    body.triangles = front.triangles;
    std::vector<Index> base(front.points.size());
    std::iota(base.begin(), base.end(), static_cast<Index>(front.positions.size()));
    for (const Triangle& t : front.triangles)
        body.triangles.push_back({base[front.rays[t[0]]], base[front.rays[t[2]]], base[front.rays[t[1]]]});
    Walls(front, base, body.triangles).add_all();
    drop_unused(body);
    while (!part_edges(body)) continue;
    return body;
}

}  // namespace hexrelief::exporters
