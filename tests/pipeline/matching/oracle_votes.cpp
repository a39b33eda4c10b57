// Steps 9 to 12 and 17 of the recipe in matching_oracle.h: discontinuities, votes, smoothing, sides,
// certainty.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "matching_oracle.h"

namespace hexrelief::matching::oracle {
namespace {

bool beside_step(const Grid& map, int x, int y) {
    if (map.at(x, y) == kUnknown) return false;
    for (const auto& [i, j] : std::vector<std::pair<int, int>>{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const int other = map.at_or(x + i, y + j, kUnknown);
        if (other != kUnknown && std::abs(other - map.at(x, y)) > 24) return true;
    }
    return false;
}

int vote_weight(int color_step, int rings, int own, bool of_hole) {
    if (color_step >= 32) return 0;
    const double r = rings / (of_hole ? 4.0 : 7.0);
    const int distance = static_cast<int>(std::lround(16 * std::exp(-r * r)));
    const int likeness = (32 - color_step) * (32 - color_step) / 16;
    return (of_hole ? likeness * likeness / 64 : likeness) * distance * own / 32;
}

struct Vote {
    int disparity, weight;
};

int weighted_median(std::vector<Vote> votes, int without) {
    int total = 0, up_to = 0;
    for (const Vote& vote : votes) total += vote.weight;
    if (total == 0) return without;
    std::sort(votes.begin(), votes.end(),
              [](const Vote& a, const Vote& b) { return a.disparity < b.disparity; });
    for (const Vote& vote : votes) {
        up_to += vote.weight;
        if (2 * up_to >= total) return vote.disparity;
    }
    return without;
}

Picture blurred(const Picture& picture) {
    Picture result = picture;
    for (std::size_t c = 0; c < picture.channels.size(); ++c)
        for (int y = 0; y < picture.grey.height; ++y)
            for (int x = 0; x < picture.grey.width; ++x) {
                int sum = 0;
                for (int j = -1; j <= 1; ++j)
                    for (int i = -1; i <= 1; ++i) sum += picture.channels[c].clamped(x + i, y + j);
                result.channels[c].at(x, y) = rounded(sum, 9);
            }
    return result;
}

int voted(const Voters& voters, const Picture& left, bool of_hole, int x, int y) {
    std::vector<Vote> votes;
    const int stride = of_hole ? 7 : 1, radius = of_hole ? 4 : 6;
    for (int j = -radius; j <= radius; ++j)
        for (int i = -radius; i <= radius; ++i) {
            if (!of_hole && (std::abs(i) + std::abs(j)) % 2) continue;
            const int ox = x + i * stride, oy = y + j * stride;
            if (voters.map.at_or(ox, oy, kUnknown) == kUnknown) continue;
            const int change =
                voters.slopes.x.at(ox, oy) * i * stride + voters.slopes.y.at(ox, oy) * j * stride;
            const int d = std::max(0, voters.map.at(ox, oy) - cut_down(change, 16));
            const int column = x - voters.min_px - rounded(d, 16);
            if (d - voters.nearest.at_or(column, y, kAnything) > 16) continue;
            const int rings = std::max(std::abs(i), std::abs(j));
            const int step = color_step(left, x, y, ox, oy);
            votes.push_back({d, vote_weight(step, rings, voters.weights.at(ox, oy), of_hole)});
        }
    return weighted_median(votes, voters.map.at(x, y));
}

int smoothed(const Grid& map, const Planes& slopes, const Picture& left, int stride, int x, int y) {
    const int own = map.at(x, y);
    if (own == kUnknown) return kUnknown;
    int sum = 0, weights = 0;
    for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i) {
            const int dx = i * stride, dy = j * stride;
            const int other = map.at_or(x + dx, y + dy, kUnknown);
            if (other == kUnknown || color_step(left, x, y, x + dx, y + dy) > 20) continue;
            const int along_x = slopes.x.at(x, y) + slopes.x.at(x + dx, y + dy);
            const int along_y = slopes.y.at(x, y) + slopes.y.at(x + dx, y + dy);
            const int off = other - own - rounded(along_x * dx + along_y * dy, 32);
            if (std::abs(off) >= 44) continue;
            const int weight = (3 - std::abs(i)) * (3 - std::abs(j)) * (44 - std::abs(off));
            sum += weight * off;
            weights += weight;
        }
    return std::max(0, own + rounded(sum, weights));
}

int side_difference(const Pictures& pictures, int x, int y, int position) {
    const int column = cut_down(position, 16), part = position - 16 * column;
    int sum = 0;
    for (std::size_t c = 0; c < pictures.left.channels.size(); ++c) {
        const Grid& right = pictures.right.channels[c];
        const int mixed =
            rounded((16 - part) * right.at(column, y) + part * right.clamped(column + 1, y), 16);
        sum += std::min(40, std::abs(mixed - pictures.left.channels[c].at(x, y)));
    }
    return pictures.left.channels.size() == 1 ? 3 * sum : sum;
}

int side(const Grid& map, const Pictures& pictures, const Grid& nearest, int min_px, int x, int y) {
    const int own = map.at(x, y), last = 16 * (map.width - 1);
    const auto position = [&](int d) { return 16 * (x - min_px) - d; };
    const auto seen = [&](int d) { return nearest.at(x - min_px - rounded(d, 16), y); };
    if (own == kUnknown || position(own) < 0 || position(own) > last) return own;
    if (seen(own) != kAnything && seen(own) - own > 16) return own;
    int least = own, most = own, best = own, difference = side_difference(pictures, x, y, position(own)) - 20;
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
            const int other = map.at_or(x + i, y + j, kUnknown);
            if (other == kUnknown) continue;
            least = std::min(least, other);
            most = std::max(most, other);
        }
    for (const int other : {least, most}) {
        if (std::abs(other - own) <= 24 || position(other) < 0 || position(other) > last) continue;
        if (other - seen(other) > 16) continue;
        const int there = side_difference(pictures, x, y, position(other));
        if (there < difference) best = other;
        difference = std::min(difference, there);
    }
    return best;
}

// The sides of the blocks around (x, y); none if empty.
std::vector<int> sides_around(const Grid& map, const Grid& at_steps, int x, int y) {
    std::vector<int> values;
    for (int v = (y / 8 - 1) * 8; v < (y / 8 + 2) * 8; ++v)
        for (int u = (x / 8 - 1) * 8; u < (x / 8 + 2) * 8; ++u)
            if (at_steps.at_or(u, v, 0)) values.push_back(map.at(u, v));
    if (values.empty()) return {};
    return {*std::min_element(values.begin(), values.end()), *std::max_element(values.begin(), values.end())};
}

Certainty certainty_of(const std::vector<int>& surfaces, int own, const Pictures& pictures,
                       const Grid& nearest, int min_px, int x, int y) {
    const auto position = [&](int d) { return 16 * (x - min_px) - d; };
    const auto inside = [&](int d) { return position(d) >= 0 && position(d) <= 16 * (nearest.width - 1); };
    const auto seen = [&](int d) { return nearest.at(x - min_px - rounded(d, 16), y); };
    const auto hidden = [&](int d) { return seen(d) != kAnything && seen(d) - d > 16; };
    if (own == kUnknown || !inside(own) || hidden(own)) return certain;
    const int difference = side_difference(pictures, x, y, position(own));
    Certainty result = certain;
    for (const int other : surfaces) {
        if (std::abs(other - own) <= 24 || !inside(other) || other - seen(other) > 16) continue;
        const int more = difference - (hidden(other) ? 40 : side_difference(pictures, x, y, position(other)));
        result = std::min(result, more >= 7 ? wrong : more > -7 ? undecided : certain);
    }
    return result;
}

}  // namespace

Grid certainty(const Grid& map, const Pictures& pictures, const Grid& nearest, int min_px) {
    Grid result(map.width, map.height, certain), at_steps(map.width, map.height, 0);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) at_steps.at(x, y) = beside_step(map, x, y);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            result.at(x, y) = certainty_of(sides_around(map, at_steps, x, y), map.at(x, y), pictures, nearest,
                                           min_px, x, y);
    return result;
}

Grid sides(const Grid& map, const Pictures& pictures, const Grid& nearest, int min_px) {
    Grid result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) result.at(x, y) = side(map, pictures, nearest, min_px, x, y);
    return result;
}

Grid near_windows(const Grid& map) {
    Grid windows(map.width, map.height, Window::none);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if (!beside_step(map, x, y)) continue;
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    if (windows.inside(x + i, y + j)) windows.at(x + i, y + j) = Window::near;
        }
    return windows;
}

Grid votes(const Voters& voters, const Picture& left, const Grid& windows) {
    Grid result = voters.map;
    const Picture soft = blurred(left);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x) {
            const bool of_hole = windows.at(x, y) == Window::hole;
            if (windows.at(x, y) != Window::none)
                result.at(x, y) = voted(voters, of_hole ? soft : left, of_hole, x, y);
        }
    return result;
}

Grid smooth(const Grid& map, const Picture& left) {
    const Planes planes = slopes(map);
    Grid result = map;
    for (const int stride : {1, 2, 4}) {
        const Grid before = result;
        for (int y = 0; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x)
                result.at(x, y) = smoothed(before, planes, left, stride, x, y);
    }
    return result;
}

}  // namespace hexrelief::matching::oracle
