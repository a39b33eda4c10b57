#include "pipeline/stages/other_views/view_place.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/union_find.h"

namespace hexrelief::stages {
namespace {

constexpr double kSetBack_px = 0.3;   // more than the noise of a match
constexpr double kFarther_px = 1;     // of this view: a guess that is so much farther than all else is wrong
constexpr double kInFront_px = 0.02;  // what is less in front is not seen to be
constexpr double kMostPush_px = 1;    // what is farther in front lies beside a silhouette
constexpr int kPushes = 3;
constexpr double kEverything_px = std::numeric_limits<double>::infinity();
constexpr double kSamples_per_px = 1.5;
constexpr int kSplits = 2;  // of a triangle that is partly in front
constexpr int kMoves = 8;   // a vertex that moves is before another place of the surface
// Nobody would miss a piece that shows less than this share of its view, nor one of which a camera sees less
// than so many square pixels where it sees nothing else.
constexpr double kLeastPieceShare = 1. / 2000, kLeastOpen_px2 = 3;

View view_from(const SurfaceMesh& mesh, const ViewPlace& place) {
    View view{{}, &mesh.triangles, place.width, place.height};
    view.points.reserve(mesh.image_points.size());
    for (std::size_t i = 0; i < mesh.image_points.size(); ++i)
        view.points.push_back(
            place.from_left({mesh.image_points[i].x, mesh.image_points[i].y, mesh.disparities[i]}));
    return view;
}

bool is_placed(const DisparityMesh& mesh, const Triangle& t) {
    return std::all_of(t.begin(), t.end(),
                       [&](std::uint32_t v) { return DisparityMap::known(mesh.disparities[v]); });
}

// How far, in px of the left view, a triangle is in front of what cameras see; 0 = not at all.
struct InFront {
    double most_px = 0;
    double little_px = 0;  // the same where it is in front by at most kMostPush_px
};

// True if all that the view shows where it has the triangle is nearer than the triangle's corners.
bool is_all_behind(const SeenSurface& seen, const ViewPoint& a, const ViewPoint& b, const ViewPoint& c) {
    const auto pixel = [](double at, int size) { return static_cast<int>(std::clamp(at, 0.0, size - 1.0)); };
    const int left = pixel(std::min({a.x, b.x, c.x}), seen.place.width),
              right = pixel(std::max({a.x, b.x, c.x}), seen.place.width),
              top = pixel(std::min({a.y, b.y, c.y}), seen.place.height),
              bottom = pixel(std::max({a.y, b.y, c.y}), seen.place.height);
    const double nearest = std::max({a.d, b.d, c.d});
    bool is_behind = true;
    for (int y = top; y <= bottom; ++y) {
        const double* const row = &seen.disparities[static_cast<std::size_t>(y) * seen.place.width];
        for (int x = left; x <= right; ++x) is_behind &= !(row[x] < nearest) || row[x] == kNotCovered;
    }
    return is_behind;
}

// Looks at points of a triangle of this view less than a pixel apart, until one is in front by more than
// enough_px. Views of a point are linear in (x, y, d).
InFront in_front(const DisparityMesh& mesh, const Triangle& t, const ViewPlace& place,
                 const VisibleSurface& surface, double enough_px) {
    InFront result;
    for (const SeenSurface& seen : surface.seen) {
        const auto corner = [&](std::uint32_t v) {
            return seen.place.from_left(
                place.to_left({mesh.points[v].x, mesh.points[v].y, mesh.disparities[v]}));
        };
        const ViewPoint a = corner(t[0]), b = corner(t[1]), c = corner(t[2]);
        if (is_all_behind(seen, a, b, c)) continue;
        const double longest = std::max({std::abs(b.x - a.x), std::abs(b.y - a.y), std::abs(c.x - a.x),
                                         std::abs(c.y - a.y), std::abs(c.x - b.x), std::abs(c.y - b.y)});
        const int steps = 1 + static_cast<int>(kSamples_per_px * longest);
        const double share = 1.0 / steps;
        const int width = seen.place.width, height = seen.place.height;
        const ViewPoint to_a{share * (a.x - c.x), share * (a.y - c.y), share * (a.d - c.d)},
            to_b{share * (b.x - c.x), share * (b.y - c.y), share * (b.d - c.d)};
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; i + j <= steps; ++j) {
                const double x = c.x + i * to_a.x + j * to_b.x, y = c.y + i * to_a.y + j * to_b.y;
                if (!(x >= 0 && x < width && y >= 0 && y < height)) continue;
                const double limit =
                    seen.disparities[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
                const double over = c.d + i * to_a.d + j * to_b.d - limit;
                if (over <= 0 || limit == kNotCovered) continue;
                const double d = seen.place.scale * over;
                result.most_px = std::max(result.most_px, d);
                if (d <= kMostPush_px) result.little_px = std::max(result.little_px, d);
                if (d > enough_px) return result;
            }
    }
    return result;
}

// Moves the vertices of triangles that are a little in front of the surface away from the camera. Returns
// what is in front afterwards.
std::vector<InFront> push_back(DisparityMesh& mesh, const ViewPlace& place, const VisibleSurface& surface,
                               ThreadPool& pool) {
    const float least = static_cast<float>(surface.least_px / place.scale);
    std::vector<InFront> front(mesh.triangles.size());
    std::vector<float> pushes(mesh.points.size(), 1);  // > 0: the vertex was moved
    for (int round = 0;; ++round) {
        pool.parallel_for_chunks(front.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Triangle& t = mesh.triangles[i];
                if (is_placed(mesh, t) &&
                    std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return pushes[v] > 0; }))
                    front[i] = in_front(mesh, t, place, surface, kEverything_px);
            }
        });
        if (round == kPushes) return front;
        std::fill(pushes.begin(), pushes.end(), 0.0f);
        for (std::size_t i = 0; i < front.size(); ++i)
            if (front[i].little_px > kInFront_px)
                for (const std::uint32_t v : mesh.triangles[i])
                    pushes[v] = std::max(pushes[v], static_cast<float>(front[i].little_px / place.scale));
        for (std::size_t v = 0; v < pushes.size(); ++v)
            if (pushes[v] > 0) mesh.disparities[v] = std::max(mesh.disparities[v] - pushes[v], least);
    }
}

// The vertices in the middle of edges, by the edges' ends.
using Middles = std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>;

// Splits triangles along edges whose neighbours were split, so that they share their vertices, unless a part
// could not be kept.
template <class IsKept>
std::vector<Triangle> with_middles(std::vector<Triangle> triangles, const Middles& middles,
                                   const IsKept& is_kept, ThreadPool& pool) {
    const auto split = [&](Triangle& t) -> std::optional<Triangle> {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
            const auto middle = middles.find(std::minmax(a, b));
            if (middle == middles.end()) continue;
            const Triangle first{a, middle->second, c}, second{middle->second, b, c};
            if (!is_kept(first) || !is_kept(second)) continue;
            t = first;
            return second;
        }
        return std::nullopt;
    };
    // The second parts follow behind the triangles of a round, and are looked at in the next one.
    for (std::size_t begin = 0; begin < triangles.size();) {
        const std::size_t end = triangles.size();
        std::vector<std::vector<Triangle>> second_parts(end - begin);
        pool.parallel_for_chunks(end - begin, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i)
                for (std::optional<Triangle> second; (second = split(triangles[begin + i]));)
                    second_parts[i].push_back(*second);
        });
        for (const std::vector<Triangle>& parts : second_parts)
            triangles.insert(triangles.end(), parts.begin(), parts.end());
        begin = end;
    }
    return triangles;
}

// True if a camera sees nothing at the middle of a triangle of this view, which therefore fills a hole.
bool is_open(const DisparityMesh& mesh, const Triangle& t, const ViewPlace& place,
             const VisibleSurface& surface) {
    ViewPoint middle{0, 0, 0};
    for (const std::uint32_t v : t) {
        middle.x += mesh.points[v].x / 3.0;
        middle.y += mesh.points[v].y / 3.0;
        middle.d += mesh.disparities[v] / 3.0;
    }
    return std::any_of(surface.seen.begin(), surface.seen.end(), [&](const SeenSurface& seen) {
        const ViewPoint p = seen.place.from_left(place.to_left(middle));
        const int width = seen.place.width, height = seen.place.height;
        return p.x >= 0 && p.x < width && p.y >= 0 && p.y < height &&
               seen.disparities[static_cast<std::size_t>(p.y) * width + static_cast<std::size_t>(p.x)] ==
                   kNotCovered;
    });
}

// Returns the triangles of those pieces, joined by vertices, that somebody would miss.
std::vector<Triangle> without_small_pieces(const DisparityMesh& mesh, const std::vector<Triangle>& triangles,
                                           const ViewPlace& place, const VisibleSurface& surface) {
    UnionFind pieces(mesh.points.size());
    for (const Triangle& t : triangles) {
        pieces.join(t[0], t[1]);
        pieces.join(t[0], t[2]);
    }
    std::vector<double> areas_px2(mesh.points.size()), open_px2(mesh.points.size());
    for (const Triangle& t : triangles) {
        const Vec2f &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
        const double area_px2 = std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2;
        areas_px2[pieces.find(t[0])] += area_px2;
        if (is_open(mesh, t, place, surface)) open_px2[pieces.find(t[0])] += area_px2;
    }
    const double least_px2 = kLeastPieceShare * place.width * place.height;
    std::vector<Triangle> kept;
    for (const Triangle& t : triangles)
        if (const auto piece = pieces.find(t[0]);
            areas_px2[piece] >= least_px2 || open_px2[piece] >= kLeastOpen_px2)
            kept.push_back(t);
    return kept;
}

}  // namespace

ViewPoint ViewPlace::from_left(const ViewPoint& p) const {
    const double d = p.d - shift_px;
    return {(p.x - right * d) / scale, (p.y + up * d) / scale, p.d / scale};
}

ViewPoint ViewPlace::to_left(const ViewPoint& p) const {
    const double d = p.d * scale - shift_px;
    return {p.x * scale + right * d, p.y * scale - up * d, p.d * scale};
}

Calibration camera_at(const ViewPlace& place, const Calibration& left) {
    Calibration camera = left;
    const double shift_px = left.doffs_px + place.shift_px;
    camera.focal_px = left.focal_px / place.scale;
    camera.cx = (left.cx + place.right * shift_px) / place.scale;
    camera.cy = (left.cy - place.up * shift_px) / place.scale;
    camera.doffs_px = left.doffs_px / place.scale;
    camera.width = place.width;
    camera.height = place.height;
    return camera;
}

double SeenSurface::limit_at(const ViewPoint& left_point) const {
    return limit_around(left_point, 0);
}

double SeenSurface::limit_around(const ViewPoint& left_point, int radius) const {
    constexpr double none = std::numeric_limits<double>::infinity();
    const ViewPoint p = place.from_left(left_point);
    if (!(p.x >= 0 && p.x < place.width && p.y >= 0 && p.y < place.height)) return none;
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    double least = none;
    for (int v = std::max(0, y - radius); v <= std::min(place.height - 1, y + radius); ++v)
        for (int u = std::max(0, x - radius); u <= std::min(place.width - 1, x + radius); ++u)
            if (const double d = disparities[static_cast<std::size_t>(v) * place.width + u]; d != kNotCovered)
                least = std::min(least, d * place.scale);
    return least;
}

SeenSurface see(const SurfaceMesh& mesh, const ViewPlace& place, int threads) {
    return {place, rasterise_disparity(view_from(mesh, place), threads)};
}

VisibleSurface visible_surface(const SurfaceMesh& mesh, const std::vector<ViewPlace>& cameras,
                               double least_px, int threads) {
    VisibleSurface surface{{}, least_px};
    for (const ViewPlace& camera : cameras) surface.seen.push_back(see(mesh, camera, threads));
    return surface;
}

void cover(VisibleSurface& surface, const SurfaceMesh& added, int threads) {
    for (SeenSurface& seen : surface.seen)
        rasterise_over(seen.disparities, view_from(added, seen.place), threads);
}

float behind(ViewPoint point, const ViewPlace& place, const VisibleSurface& surface) {
    for (int moves = 0; moves < kMoves; ++moves) {
        const ViewPoint in_left = place.to_left(point);
        double limit = in_left.d;
        for (const SeenSurface& seen : surface.seen)
            limit = std::min(limit, seen.limit_around(in_left, 1) - kSetBack_px);
        if (limit == in_left.d) break;
        point.d = limit / place.scale;
    }
    const double least = surface.least_px / place.scale;
    return point.d < least - kFarther_px ? kUnknownDisparity : static_cast<float>(std::max(point.d, least));
}

void keep_behind(DisparityMesh& cut_mesh, const ViewPlace& place, const VisibleSurface& surface,
                 double most_step_px, int threads) {
    ThreadPool pool(threads);
    std::vector<float> given = cut_mesh.disparities;
    pool.parallel_for(cut_mesh.points.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec2f& p = cut_mesh.points[i];
            cut_mesh.disparities[i] = behind({p.x, p.y, cut_mesh.disparities[i]}, place, surface);
        }
    });
    const std::vector<InFront> front = push_back(cut_mesh, place, surface, pool);
    const auto is_kept = [&](const Triangle& t) {
        return is_placed(cut_mesh, t) &&
               in_front(cut_mesh, t, place, surface, kInFront_px).most_px <= kInFront_px;
    };
    Middles middles;
    const auto add_middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [found, is_new] =
            middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(cut_mesh.points.size()));
        if (!is_new) return found->second;
        const Vec2f p{(cut_mesh.points[a].x + cut_mesh.points[b].x) / 2,
                      (cut_mesh.points[a].y + cut_mesh.points[b].y) / 2};
        const double d = (cut_mesh.disparities[a] + cut_mesh.disparities[b]) / 2;
        cut_mesh.points.push_back(p);
        given.push_back((given[a] + given[b]) / 2);
        cut_mesh.disparities.push_back(behind({p.x, p.y, d}, place, surface));
        return found->second;
    };
    cut_mesh.has_one_fan_per_vertex = false;
    std::vector<Triangle> kept, split;
    const auto split_in_four = [&](const Triangle& t) {
        const std::uint32_t ab = add_middle(t[0], t[1]), bc = add_middle(t[1], t[2]),
                            ca = add_middle(t[2], t[0]);
        split.insert(split.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    };
    for (std::size_t i = 0; i < cut_mesh.triangles.size(); ++i) {
        const Triangle t = cut_mesh.triangles[i];
        if (!is_placed(cut_mesh, t)) continue;
        if (front[i].most_px <= kInFront_px)
            kept.push_back(t);
        else
            split_in_four(t);
    }
    for (int round = 1; round <= kSplits; ++round) {
        const std::vector<Triangle> parts = std::exchange(split, {});
        std::vector<char> are_kept(parts.size());
        pool.parallel_for_chunks(parts.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) are_kept[i] = is_kept(parts[i]);
        });
        for (std::size_t i = 0; i < parts.size(); ++i) {
            if (are_kept[i])
                kept.push_back(parts[i]);
            else if (round < kSplits && is_placed(cut_mesh, parts[i]))
                split_in_four(parts[i]);
        }
    }
    std::vector<Triangle> all = with_middles(std::move(kept), middles, is_kept, pool);
    std::erase_if(all, [&](const Triangle& t) {
        const auto step_of = [&](const std::vector<float>& disparities) {
            const auto [least, largest] =
                std::minmax({disparities[t[0]], disparities[t[1]], disparities[t[2]]});
            return largest - least;
        };
        return (step_of(cut_mesh.disparities) - step_of(given)) * place.scale > most_step_px;
    });
    cut_mesh.triangles = without_small_pieces(cut_mesh, all, place, surface);
}

SurfaceMesh in_left_space(SurfaceMesh mesh, const ViewPlace& place, const Calibration& left) {
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        mesh.positions[i].x += static_cast<float>(place.right * left.baseline_m);
        mesh.positions[i].y += static_cast<float>(place.up * left.baseline_m);
        const ViewPoint p =
            place.to_left({mesh.image_points[i].x, mesh.image_points[i].y, mesh.disparities[i]});
        mesh.image_points[i] = {static_cast<float>(p.x), static_cast<float>(p.y)};
        mesh.disparities[i] = static_cast<float>(p.d);
    }
    return mesh;
}

void append(SurfaceMesh& mesh, const SurfaceMesh& other, PartOrigin origin) {
    if (mesh.parts.empty())
        mesh.parts.push_back({PartOrigin::left, mesh.positions.size(), mesh.triangles.size()});
    mesh.parts.push_back({origin, other.positions.size(), other.triangles.size()});
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    add(mesh.positions, other.positions);
    add(mesh.normals, other.normals);
    add(mesh.texcoords, other.texcoords);
    add(mesh.image_points, other.image_points);
    add(mesh.disparities, other.disparities);
    for (const Triangle& t : other.triangles)
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

}  // namespace hexrelief::stages
