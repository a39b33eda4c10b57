// Steps 1 to 5: which neighbouring pixels lie on one surface.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "naive_slope.h"
#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

using Region = std::vector<std::size_t>;  // pixels

template <typename Visit>
void each_neighbour(const Surfaces& s, std::size_t i, const Visit& visit) {
    const int x = static_cast<int>(i) % s.width, y = static_cast<int>(i) / s.width;
    if (x > 0) visit(s.index(x - 1, y));
    if (x + 1 < s.width) visit(s.index(x + 1, y));
    if (y > 0) visit(s.index(x, y - 1));
    if (y + 1 < s.height) visit(s.index(x, y + 1));
}

// Returns regions of 4-connected pixels; joined(i, j) for neighbours i < j.
template <typename Belongs, typename Joined>
std::vector<Region> regions_of(const Surfaces& s, const Belongs& belongs, const Joined& joined) {
    std::vector<Region> regions;
    std::vector<bool> seen(s.disparity.size(), false);
    for (std::size_t start = 0; start < seen.size(); ++start) {
        if (seen[start] || !belongs(start)) continue;
        Region region{start};
        seen[start] = true;
        for (std::size_t at = 0; at < region.size(); ++at) {
            const std::size_t i = region[at];
            each_neighbour(s, i, [&](std::size_t j) {
                if (seen[j] || !belongs(j) || !joined(std::min(i, j), std::max(i, j))) return;
                seen[j] = true;
                region.push_back(j);
            });
        }
        regions.push_back(region);
    }
    return regions;
}

void keep_foreground(const DisparityMap& map, float background_px, Surfaces& s) {
    for (const float d : map.values)
        s.disparity.push_back(std::isfinite(d) && d > 0 && !(d < background_px) ? d : 0.0f);
}

// Both cameras see a surface that rises by at most a pixel per pixel; 1/64 px allows for rounding.
float least_jump(const Config& config) {
    return config.least_discontinuity_px > 0 ? static_cast<float>(config.least_discontinuity_px)
                                             : 1 + 1.0f / 64;
}

// A single pixel between two steps down to the right, the farther one below 4 px, that are not parts of a
// longer slope, takes the disparity of the farther surface.
void settle_pixels_between_steps(Surfaces& s) {
    const float least = s.least_jump_px;
    const std::vector<float> before = s.disparity;
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            const auto at = [&](int u) { return u < 0 || u >= s.width ? 0.0f : before[s.index(u, y)]; };
            const float own = at(x), right = at(x + 1), right2 = at(x + 2);
            const bool between = right > 0 && at(x - 1) - own > least && own - right > least;
            const bool slope = at(x - 2) - at(x - 1) > least || (right2 > 0 && right - right2 > least);
            if (between && own - right < 4 && !slope) s.disparity[s.index(x, y)] = right;
        }
}

// Ring by ring from the regions' borders, pixels take the least, or largest, disparity
// of their settled neighbours.
void absorb(const std::vector<Region>& regions, bool least, Surfaces& s) {
    std::set<std::size_t> unsettled;
    for (const Region& region : regions) unsettled.insert(region.begin(), region.end());
    for (const std::size_t i : unsettled) s.trusted[i] = false;
    for (bool any = true; any;) {
        std::vector<std::pair<std::size_t, float>> ring;
        for (const std::size_t i : unsettled) {
            std::vector<float> around;
            each_neighbour(s, i, [&](std::size_t j) {
                if (!unsettled.contains(j)) around.push_back(s.disparity[j]);
            });
            if (around.empty()) continue;
            const auto [low, high] = std::minmax_element(around.begin(), around.end());
            ring.emplace_back(i, least ? *low : *high);
        }
        for (const auto& [i, d] : ring) s.disparity[i] = d, unsettled.erase(i);
        any = !ring.empty();
    }
}

// Absorbs regions without foreground that are smaller than a lattice cell.
void absorb_holes(double cell_px, Surfaces& s) {
    const auto empty = [&](std::size_t i) { return !(s.disparity[i] > 0); };
    std::vector<Region> holes = regions_of(s, empty, [](std::size_t, std::size_t) { return true; });
    std::erase_if(holes, [&](const Region& hole) { return !(static_cast<double>(hole.size()) < cell_px); });
    absorb(holes, true, s);
}

// Absorbs regions between discontinuities of less than 5 pixels.
void absorb_speckles(Surfaces& s) {
    const auto joined = [&](std::size_t i, std::size_t j) { return !s.jumps[j != i + 1][i]; };
    std::vector<Region> regions = regions_of(
        s, [](std::size_t) { return true; }, joined);
    std::erase_if(regions, [&](const Region& region) { return region.size() >= 5; });
    absorb(regions, false, s);
}

// The disparities of a row or column as seen from the crack edge c: at(0) and at(1) lie beside it;
// 0 outside the image.
struct Profile {
    const Surfaces& s;
    CrackEdge c;
    float at(int k) const {
        const int x = c.down ? c.x : c.x + k, y = c.down ? c.y + k : c.y;
        return x < 0 || y < 0 || x >= s.width || y >= s.height ? 0.0f : s.at(x, y);
    }
};

bool is_step(const Profile& p, float least) {
    return (p.at(0) > 0) != (p.at(1) > 0) || std::fabs(p.at(0) - p.at(1)) > least;
}

// True if the step is the steepest part, the first of equal ones, of a step of up to 2.3 px that is spread
// over several pixels; higher steps always are.
bool is_steepest(const Profile& p) {
    const float before = p.at(-1), own = p.at(0), other = p.at(1), after = p.at(2);
    const float height = std::fabs(other - own);
    if (!(own > 0) || !(other > 0) || height > 2.3f) return true;
    const auto same_way = [&](float difference) { return (difference > 0) == (other - own > 0); };
    const bool weaker_than_before = before > 0 && same_way(own - before) && std::fabs(own - before) >= height;
    const bool weaker_than_after = after > 0 && same_way(after - other) && std::fabs(after - other) > height;
    return !weaker_than_before && !weaker_than_after;
}

bool is_slope(const Profile& p, float least) {
    return NaiveColumn{[&](int k) { return p.at(k); }, p.c.y, p.s.height - 2 - p.c.y}.is_slope(least);
}

void find_discontinuities(const Config& config, Surfaces& s) {
    const float least = config.bridge ? std::numeric_limits<float>::infinity() : s.least_jump_px;
    for (int down = 0; down < 2; ++down) {
        s.jumps[down].assign(s.disparity.size(), false);
        for (int y = 0; y + down < s.height; ++y)
            for (int x = 0; x + 1 - down < s.width; ++x) {
                const Profile p{s, {x, y, down == 1}};
                s.jumps[down][s.index(x, y)] =
                    is_step(p, least) && is_steepest(p) && !(down == 1 && is_slope(p, least));
            }
    }
}

}  // namespace

std::vector<CrackEdge> all_discontinuities(const Surfaces& s) {
    std::vector<CrackEdge> found;
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x)
            for (const bool down : {false, true})
                if (s.has({x, y, down})) found.push_back({x, y, down});
    return found;
}

Surfaces find_surfaces(const DisparityMap& map, float background_px, double cell_px, const Config& config) {
    Surfaces s;
    s.width = map.width;
    s.height = map.height;
    s.trusted.assign(map.values.size(), true);
    keep_foreground(map, background_px, s);
    s.least_jump_px = least_jump(config);
    if (!config.bridge) settle_pixels_between_steps(s);
    absorb_holes(cell_px, s);
    find_discontinuities(config, s);
    absorb_speckles(s);
    find_discontinuities(config, s);
    return s;
}

}  // namespace hexrelief::surface::oracle
