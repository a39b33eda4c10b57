#include "exporters/formats/bridge_holes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace hexrelief::exporters {
namespace {

using Index = std::uint32_t;

// A side of the border, in the direction of its triangle.
struct BorderSide {
    Index from_ray, to_ray, from, to;
    bool is_taken = false;
};

class Holes {
  public:
    Holes(const std::vector<Triangle>& triangles, const std::vector<Index>& rays,
          const std::vector<Vec2f>& points)
        : rays_(rays), points_(points) {
        std::vector<std::pair<Index, Index>> sides;
        const auto visit = [&](auto&& visitor) {
            for (const Triangle& t : triangles)
                for (std::size_t k = 0; k < 3; ++k) visitor(t[k], t[(k + 1) % 3]);
        };
        visit([&](Index from, Index to) { sides.emplace_back(rays[from], rays[to]); });
        std::ranges::sort(sides);
        visit([&](Index from, Index to) {
            if (!std::ranges::binary_search(sides, std::pair(rays[to], rays[from])))
                border_.push_back({rays[from], rays[to], from, to});
        });
        std::ranges::sort(border_, {}, [](const BorderSide& s) { return std::pair(s.from_ray, s.to_ray); });
        for (const Triangle& t : triangles) turn_ += cross(t[0], t[1], t[2]);
    }

    // Returns the next loop of the border that is a hole, as its corners in the order of triangles inside it.
    std::optional<std::vector<Index>> next(double most) {
        for (; begun_ < border_.size(); ++begun_) {
            if (border_[begun_].is_taken) continue;
            std::vector<Index> corners = loop_from(begun_);
            const double area = area_of(corners);
            const bool is_hole = area * turn_ < 0 && std::abs(area) < most;
            if (corners.size() < 3 || corners.size() > kMostHoleSides || !is_hole) continue;
            std::ranges::reverse(corners);
            return corners;
        }
        return std::nullopt;
    }

    // Returns triangles inside the corners, cut off ear by ear; none if there are none without crossings.
    std::vector<Triangle> inside(std::vector<Index> corners) const {
        std::vector<Triangle> triangles;
        std::size_t at = 0, tried = 0;
        while (corners.size() > 3 && tried < corners.size()) {
            const std::size_t n = corners.size();
            const Index before = corners[(at + n - 1) % n], ear = corners[at], after = corners[(at + 1) % n];
            if (is_ear(corners, before, ear, after)) {
                triangles.push_back({before, ear, after});
                corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(at));
                at %= corners.size();
                tried = 0;
            } else {
                at = (at + 1) % n;
                ++tried;
            }
        }
        if (corners.size() > 3 || cross(corners[0], corners[1], corners[2]) * turn_ <= 0) return {};
        triangles.push_back({corners[0], corners[1], corners[2]});
        return triangles;
    }

  private:
    const Vec2f& point(Index vertex) const { return points_[rays_[vertex]]; }

    // Returns twice the signed area.
    double cross(Index a, Index b, Index c) const {
        const Vec2f &p = point(a), &q = point(b), &r = point(c);
        return double(q.x - p.x) * (r.y - p.y) - double(r.x - p.x) * (q.y - p.y);
    }
    double area_of(const std::vector<Index>& corners) const {
        double area = 0;
        for (std::size_t i = 1; i + 1 < corners.size(); ++i)
            area += cross(corners[0], corners[i], corners[i + 1]);
        return area;
    }

    // Takes sides from one on, each beginning where the one before ends, and returns where they begin; fewer
    // than three corners if they do not close.
    std::vector<Index> loop_from(std::size_t first) {
        std::vector<Index> corners;
        const Index start = border_[first].from_ray;
        Index arrived = 0;
        for (BorderSide* side = &border_[first]; side != nullptr;) {
            side->is_taken = true;
            corners.push_back(std::max(side->from, arrived));
            arrived = side->to;
            if (side->to_ray == start) {
                corners[0] = std::max(corners[0], arrived);
                return corners;
            }
            side = free_side_from(side->to_ray);
        }
        return {};
    }

    BorderSide* free_side_from(Index ray) {
        auto at = std::partition_point(border_.begin(), border_.end(),
                                       [ray](const BorderSide& side) { return side.from_ray < ray; });
        for (; at != border_.end() && at->from_ray == ray; ++at)
            if (!at->is_taken) return &*at;
        return nullptr;
    }

    bool is_ear(const std::vector<Index>& corners, Index before, Index ear, Index after) const {
        if (cross(before, ear, after) * turn_ <= 0) return false;
        return std::ranges::none_of(corners, [&](Index i) {
            return cross(before, ear, i) * turn_ > 0 && cross(ear, after, i) * turn_ > 0 &&
                   cross(after, before, i) * turn_ > 0;
        });
    }

    const std::vector<Index>& rays_;
    const std::vector<Vec2f>& points_;
    std::vector<BorderSide> border_;
    double turn_ = 0;  // its sign is that of a triangle's area
    std::size_t begun_ = 0;
};

}  // namespace

void bridge_holes(std::vector<Triangle>& triangles, const std::vector<Index>& rays,
                  const std::vector<Vec2f>& points, double most) {
    Holes holes(triangles, rays, points);
    while (const auto corners = holes.next(most))
        for (const Triangle& t : holes.inside(*corners)) triangles.push_back(t);
}

}  // namespace hexrelief::exporters
