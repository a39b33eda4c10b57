#include "pipeline/stages/silhouettes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {
namespace {

constexpr double kMostMove_px = 0.75;
constexpr double kSteps_px[] = {0.5, 0.25};
constexpr double kSlack_px = 0.5, kErrorCap_px = 10;
constexpr double kLeastArea = 0.3;  // least area of a triangle after a move, as a share of its first area
// Px of disparity per pixel; on steeper planes a moved vertex keeps its disparity.
constexpr double kSteepest = 1;
constexpr double kLeastCost_px2 = 0.5;  // vertices with a lower cost stay where they are
constexpr double kLeastGain = 0.01;     // least share of the cost that a move must save
constexpr int kFlatReach_px = 2;
constexpr double kFlatStep_px = 2;  // a larger step within kFlatReach_px means that a pixel is not flat
constexpr double kFront_px = 1;
// Weight of pixels that the mesh lies in front of, since it hides them from the other camera as well.
constexpr double kHidden = 3;
constexpr int kTile_px = 16;
constexpr int kMargin_px = 2;  // a vertex's largest move plus the slack, in whole pixels

double area2(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
}

// A rectangle of pixels: right and bottom are exclusive.
struct Box {
    int left, top, right, bottom;
};

struct Pixel {
    double covered = kNotCovered;  // largest disparity of the triangles that contain the centre
    // Disparity and squared distance of the nearest triangle within the slack.
    double near = kNotCovered, distance2 = kSlack_px * kSlack_px;
};

// The pixels of a box, and the triangles drawn on them so far.
struct Patch {
    Box box;
    std::vector<Pixel> pixels;

    Pixel& at(int x, int y) {
        return pixels[std::size_t(y - box.top) * (box.right - box.left) + (x - box.left)];
    }
};

struct Corner {
    double x, y, d;
};

// Updates the pixel's nearest point by the point of the segment a-b that is nearest to (x, y).
void meet_side(Pixel& pixel, double x, double y, const Corner& a, const Corner& b) {
    const double sx = b.x - a.x, sy = b.y - a.y, length2 = sx * sx + sy * sy;
    const double along = length2 > 0 ? std::clamp(((x - a.x) * sx + (y - a.y) * sy) / length2, 0.0, 1.0) : 0;
    const double dx = a.x + along * sx - x, dy = a.y + along * sy - y, distance2 = dx * dx + dy * dy;
    const double d = a.d + along * (b.d - a.d);
    if (distance2 > pixel.distance2 || (distance2 == pixel.distance2 && d <= pixel.near)) return;
    pixel.distance2 = distance2;
    pixel.near = d;
}

void draw(Patch& patch, const std::array<Corner, 3>& t) {
    const auto& [a, b, c] = t;
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(area > 0)) return;
    const auto first = [](double least, int bound) {
        return std::max(bound, static_cast<int>(std::ceil(least - kSlack_px - 0.5)));
    };
    const auto last = [](double most, int bound) {
        return std::min(bound - 1, static_cast<int>(std::floor(most + kSlack_px - 0.5)));
    };
    const int left = first(std::min({a.x, b.x, c.x}), patch.box.left),
              right = last(std::max({a.x, b.x, c.x}), patch.box.right);
    const int bottom = last(std::max({a.y, b.y, c.y}), patch.box.bottom);
    for (int y = first(std::min({a.y, b.y, c.y}), patch.box.top); y <= bottom; ++y)
        for (int x = left; x <= right; ++x) {
            const double u = x + 0.5, v = y + 0.5;
            const double wa = (b.x - u) * (c.y - v) - (b.y - v) * (c.x - u),
                         wb = (c.x - u) * (a.y - v) - (c.y - v) * (a.x - u), wc = area - wa - wb;
            Pixel& pixel = patch.at(x, y);
            if (wa >= 0 && wb >= 0 && wc >= 0)
                pixel.covered = std::max(pixel.covered, (wa * a.d + wb * b.d + wc * c.d) / area);
            else if (pixel.covered == kNotCovered)
                for (int k = 0; k < 3; ++k) meet_side(pixel, u, v, t[k], t[(k + 1) % 3]);
        }
}

class Adjuster {
  public:
    Adjuster(DisparityMesh& mesh, const DisparityMap& map, float background_px)
        : mesh_(mesh),
          map_(map),
          background_px_(background_px),
          largest_(std::max(1.f, known_range(map).largest)),
          start_(mesh.points),
          fans_(mesh.points.size()) {
        tile_columns_ = (map.width + kTile_px - 1) / kTile_px;
        tiles_.resize(std::size_t(tile_columns_) * ((map.height + kTile_px - 1) / kTile_px));
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            for (const std::uint32_t corner : mesh.triangles[t]) fans_[corner].push_back(t);
            for_tiles(box_of({t}), [&](std::vector<std::uint32_t>& tile) { tile.push_back(t); });
        }
        drawn_.resize(mesh.triangles.size());
    }

    void adjust(std::uint32_t vertex) {
        const std::vector<std::uint32_t>& fan = fans_[vertex];
        const Box box = box_of(fan);
        const Patch others = without(fan, box);
        const Vec2f from = mesh_.points[vertex];
        const float from_d = mesh_.disparities[vertex];
        const std::array<double, 2> slope = slope_at(fan);
        double least = cost(others, fan);
        if (least < kLeastCost_px2) return;
        Vec2f best = from;
        float best_d = from_d;
        for (const double step : kSteps_px)
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const Vec2f to{float(from.x + step * dx), float(from.y + step * dy)};
                    if ((dx == 0 && dy == 0) || !allowed(vertex, to)) continue;
                    mesh_.points[vertex] = to;
                    mesh_.disparities[vertex] =
                        float(from_d + slope[0] * (to.x - from.x) + slope[1] * (to.y - from.y));
                    const double here = cost(others, fan);
                    if (here < least * (1 - kLeastGain)) {
                        least = here;
                        best = to;
                        best_d = mesh_.disparities[vertex];
                    }
                }
        mesh_.points[vertex] = best;
        mesh_.disparities[vertex] = best_d;
    }

  private:
    template <typename Work>
    void for_tiles(const Box& box, const Work& work) {
        for (int y = box.top / kTile_px; y * kTile_px < box.bottom; ++y)
            for (int x = box.left / kTile_px; x * kTile_px < box.right; ++x)
                work(tiles_[std::size_t(y) * tile_columns_ + x]);
    }

    // Returns the box of all pixels that these triangles can ever cover.
    Box box_of(const std::vector<std::uint32_t>& triangles) const {
        Box box{map_.width, map_.height, 0, 0};
        for (const std::uint32_t t : triangles)
            for (const std::uint32_t corner : mesh_.triangles[t]) {
                const Vec2f& p = start_[corner];
                box = {std::min(box.left, static_cast<int>(p.x) - kMargin_px),
                       std::min(box.top, static_cast<int>(p.y) - kMargin_px),
                       std::max(box.right, static_cast<int>(p.x) + kMargin_px + 1),
                       std::max(box.bottom, static_cast<int>(p.y) + kMargin_px + 1)};
            }
        return {std::max(0, box.left), std::max(0, box.top), std::min(map_.width, box.right),
                std::min(map_.height, box.bottom)};
    }

    std::array<Corner, 3> corners(std::uint32_t t) const {
        std::array<Corner, 3> out;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh_.triangles[t][k];
            out[k] = {mesh_.points[v].x, mesh_.points[v].y, mesh_.disparities[v]};
        }
        return out;
    }

    // Returns the box with all triangles drawn except the fan's.
    Patch without(const std::vector<std::uint32_t>& fan, const Box& box) {
        Patch patch{box, std::vector<Pixel>(std::size_t(box.right - box.left) * (box.bottom - box.top))};
        ++look_;
        for (const std::uint32_t t : fan) drawn_[t] = look_;
        for_tiles(box, [&](const std::vector<std::uint32_t>& tile) {
            for (const std::uint32_t t : tile) {
                if (drawn_[t] == look_) continue;
                drawn_[t] = look_;
                draw(patch, corners(t));
            }
        });
        return patch;
    }

    bool is_scored(float d) const { return DisparityMap::known(d) && d > 0 && d >= background_px_; }

    // True if no pixel within kFlatReach_px is unscored or differs by more than kFlatStep_px. A gap in the
    // mesh would be visible at such a pixel and is not needed there, so slack does not count.
    bool is_flat(int x, int y) const {
        const float d = map_.at(x, y);
        for (int v = std::max(0, y - kFlatReach_px); v <= std::min(map_.height - 1, y + kFlatReach_px); ++v)
            for (int u = std::max(0, x - kFlatReach_px); u <= std::min(map_.width - 1, x + kFlatReach_px);
                 ++u)
                if (!is_scored(map_.at(u, v)) || std::fabs(map_.at(u, v) - d) > kFlatStep_px) return false;
        return true;
    }

    double cost_of(const Pixel& pixel, int x, int y) const {
        const double d = map_.at(x, y);
        const bool is_covered = pixel.covered != kNotCovered;
        const double seen = is_covered ? pixel.covered : pixel.near;
        double error = kErrorCap_px;
        if (is_covered || (seen != kNotCovered && !is_flat(x, y)))
            error = std::min(std::fabs(seen - d), kErrorCap_px);
        // A surface in front of the true one hides it from the other camera as well.
        const bool is_hidden = is_covered && seen > d + kFront_px;
        const double nearest = std::min<double>(is_hidden ? seen : d, largest_) / largest_;
        return (is_hidden ? kHidden : 1) * nearest * nearest * nearest * error * error;
    }

    double cost(const Patch& others, const std::vector<std::uint32_t>& fan) const {
        Patch patch = others;
        for (const std::uint32_t t : fan) draw(patch, corners(t));
        double sum = 0;
        for (int y = patch.box.top; y < patch.box.bottom; ++y)
            for (int x = patch.box.left; x < patch.box.right; ++x)
                if (is_scored(map_.at(x, y))) sum += cost_of(patch.at(x, y), x, y);
        return sum;
    }

    // Returns the slope of disparity in x and y on the fan's largest triangle; 0 if it
    // is steeper than kSteepest.
    std::array<double, 2> slope_at(const std::vector<std::uint32_t>& fan) const {
        double largest = 0;
        std::array<double, 2> slope{};
        for (const std::uint32_t t : fan) {
            const auto [a, b, c] = corners(t);
            const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            if (area <= largest) continue;
            largest = area;
            slope = {((b.d - a.d) * (c.y - a.y) - (c.d - a.d) * (b.y - a.y)) / area,
                     ((c.d - a.d) * (b.x - a.x) - (b.d - a.d) * (c.x - a.x)) / area};
        }
        if (std::fabs(slope[0]) > kSteepest || std::fabs(slope[1]) > kSteepest) return {};
        return slope;
    }

    bool allowed(std::uint32_t vertex, const Vec2f& to) const {
        const double dx = double(to.x) - start_[vertex].x, dy = double(to.y) - start_[vertex].y;
        if (dx * dx + dy * dy > kMostMove_px * kMostMove_px) return false;
        if (to.x < 0 || to.y < 0 || to.x > map_.width || to.y > map_.height) return false;
        return std::all_of(fans_[vertex].begin(), fans_[vertex].end(), [&](std::uint32_t t) {
            const auto& [a, b, c] = mesh_.triangles[t];
            const auto at = [&](std::uint32_t v) { return v == vertex ? to : mesh_.points[v]; };
            return area2(at(a), at(b), at(c)) >= kLeastArea * area2(start_[a], start_[b], start_[c]);
        });
    }

    DisparityMesh& mesh_;
    const DisparityMap& map_;
    float background_px_, largest_;
    std::vector<Vec2f> start_;
    std::vector<std::vector<std::uint32_t>> fans_;   // triangles of each vertex
    std::vector<std::vector<std::uint32_t>> tiles_;  // triangles that may reach into each tile
    int tile_columns_ = 0;
    std::vector<std::uint32_t> drawn_;  // number of the last patch on which each triangle was drawn
    std::uint32_t look_ = 0;
};

// Returns the vertices of edges that only one triangle has, ascending.
std::vector<std::uint32_t> border_vertices(const DisparityMesh& mesh) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) sides.push_back(std::minmax(t[k], t[(k + 1) % 3]));
    std::sort(sides.begin(), sides.end());
    std::vector<char> is_border(mesh.points.size());
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const bool shared =
            (i > 0 && sides[i - 1] == sides[i]) || (i + 1 < sides.size() && sides[i + 1] == sides[i]);
        if (!shared) is_border[sides[i].first] = is_border[sides[i].second] = 1;
    }
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < is_border.size(); ++v)
        if (is_border[v]) vertices.push_back(v);
    return vertices;
}

}  // namespace

void adjust_silhouettes(DisparityMesh& mesh, const DisparityMap& map, float background_px, int rounds) {
    if (rounds == 0) return;
    Adjuster adjuster(mesh, map, background_px);
    const std::vector<std::uint32_t> vertices = border_vertices(mesh);
    for (int round = 0; round < rounds; ++round)
        for (const std::uint32_t vertex : vertices) adjuster.adjust(vertex);
}

}  // namespace hexrelief::stages
