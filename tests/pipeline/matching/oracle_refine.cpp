// Steps 5 to 8, 13 and 14 of the recipe in matching_oracle.h: from winners to a map without unknown pixels.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "matching_oracle.h"

namespace hexrelief::matching::oracle {
namespace {

// Returns the disparity if the other view agrees with it, else kUnknown.
int agreed(int disparity, const Grid& other, int column, int y, int limit) {
    if (disparity == kUnknown) return kUnknown;
    const int there = other.at_or(column, y, kUnknown);
    return there != kUnknown && std::abs(there - disparity) <= limit ? disparity : kUnknown;
}

using Pixels = std::vector<std::pair<int, int>>;

Pixels patch_around(const Grid& map, int x, int y, int largest_step, Grid& seen) {
    Pixels patch{{x, y}};
    seen.at(x, y) = 1;
    for (std::size_t k = 0; k < patch.size(); ++k) {
        const auto [px, py] = patch[k];
        for (const auto& [nx, ny] : Pixels{{px - 1, py}, {px + 1, py}, {px, py - 1}, {px, py + 1}}) {
            if (!map.inside(nx, ny) || seen.at(nx, ny) || map.at(nx, ny) == kUnknown) continue;
            if (std::abs(map.at(nx, ny) - map.at(px, py)) > largest_step) continue;
            seen.at(nx, ny) = 1;
            patch.push_back({nx, ny});
        }
    }
    return patch;
}

void remove_speckles(Grid& map, const Settings& settings) {
    Grid seen(map.width, map.height, 0), result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if (map.at(x, y) == kUnknown || seen.at(x, y)) continue;
            const Pixels patch = patch_around(map, x, y, settings.speckle_step, seen);
            for (const auto& [px, py] : patch) {
                const int most = settings.speckle_pixels * (map.at(px, py) < settings.least ? 4 : 1);
                if (static_cast<int>(patch.size()) <= most) result.at(px, py) = kUnknown;
            }
        }
    map = result;
}

// Returns the slope of the least squares line through the pixel's run along (dx, dy).
int line_slope(const Grid& map, int x, int y, int dx, int dy) {
    if (map.at(x, y) == kUnknown) return 0;
    int n = 1, t = 0, v = 0, tt = 0, tv = 0;
    for (const int side : {-1, 1})
        for (int k = 1; k <= 4; ++k) {
            const int before = map.at(x + side * (k - 1) * dx, y + side * (k - 1) * dy);
            const int here = map.at_or(x + side * k * dx, y + side * k * dy, kUnknown);
            if (here == kUnknown || std::abs(here - before) > 20) break;
            ++n;
            t += side * k;
            v += here;
            tt += k * k;
            tv += side * k * here;
        }
    v += map.at(x, y);
    if (n < 4) return 0;
    return std::clamp(rounded(16 * (n * tv - t * v), n * tt - t * t), -512, 512);
}

int window_mean(const Grid& map, const Grid& lines, int stride, int x, int y) {
    int sum = 0, n = 0;
    for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i) {
            const int other = map.at_or(x + i * stride, y + j * stride, kUnknown);
            if ((std::abs(i) + std::abs(j)) % 2) continue;
            if (other == kUnknown || std::abs(other - map.at(x, y)) > 24) continue;
            sum += lines.at(x + i * stride, y + j * stride);
            ++n;
        }
    return rounded(sum, n);
}

// Returns the disparity of the nearest known pixel's plane in a direction, -1 if there is none.
int candidate(const Grid& map, const Planes& slopes, int x, int y, int dx, int dy) {
    for (int k = 1; map.inside(x + k * dx, y + k * dy); ++k) {
        const int known_x = x + k * dx, known_y = y + k * dy, far = std::min(k, 16);
        if (map.at(known_x, known_y) == kUnknown) continue;
        const int change = -far * (dx * slopes.x.at(known_x, known_y) + dy * slopes.y.at(known_x, known_y));
        return std::max(0, map.at(known_x, known_y) + cut_down(change, 16));
    }
    return -1;
}

int median(std::vector<int> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

// Returns the frame rule's disparity, -1 if the rule does not apply. east: the candidates of E, NE, SE.
int beyond_frame(int x, int min_px, const std::vector<int>& east) {
    std::vector<int> beyond;
    const auto is_beyond = [&](int d) { return x - min_px - d / 16.0 < 0.5; };
    for (const int d : east)
        if (d >= 0 && is_beyond(d)) beyond.push_back(d);
    if (beyond.empty() || (east[0] >= 0 && !is_beyond(east[0]))) return -1;
    return median(beyond);
}

// Returns the difference of colours of the 3x3 pixels around (x, y) and around its match,
// which must be inside.
int window_difference(const Pictures& pictures, int x, int y, int position) {
    const int column = position / 16, part = position % 16;
    int sum = 0;
    for (std::size_t c = 0; c < pictures.left.channels.size(); ++c)
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) {
                const Grid& right = pictures.right.channels[c];
                const int here = right.clamped(column + i, y + j),
                          next = right.clamped(column + i + 1, y + j);
                const int mixed = rounded((16 - part) * here + part * next, 16);
                sum += std::min(40, std::abs(mixed - pictures.left.channels[c].clamped(x + i, y + j)));
            }
    return pictures.left.channels.size() == 1 ? 3 * sum : sum;
}

// Returns the disparity with the most similar colours. `sorted` holds candidates, none of
// them hidden or matched.
int most_alike(const std::vector<int>& sorted, const Pictures& pictures, int x, int y, int min_px) {
    const int guess = sorted.size() >= 5 ? sorted[1] : sorted[0];
    std::vector<std::pair<int, int>> inside;  // difference, disparity
    int guess_difference = 1000000;
    for (const int d : sorted) {
        const int position = 16 * (x - min_px) - d;
        if (position < 0 || position > 16 * (pictures.left.grey.width - 1)) continue;
        inside.push_back({window_difference(pictures, x, y, position), d});
        if (d == guess) guess_difference = inside.back().first;
    }
    if (inside.empty()) return guess;
    const auto best = *std::min_element(inside.begin(), inside.end());
    return guess_difference - best.first >= 108 ? best.second : guess;
}

int filled(const Trusted& matches, const Planes& slopes, const Pictures& pictures, int x, int y, int min_px) {
    const auto towards = [&](int dx, int dy) { return candidate(matches.left, slopes, x, y, dx, dy); };
    const std::vector<int> east{towards(1, 0), towards(1, -1), towards(1, 1)};
    if (const int beyond = beyond_frame(x, min_px, east); beyond >= 0) return beyond;

    const std::vector<int> others{towards(0, -1), towards(0, 1), towards(-1, 0), towards(-1, -1),
                                  towards(-1, 1)};
    std::vector<int> all = east, visible;
    all.insert(all.end(), others.begin(), others.end());
    all.erase(std::remove(all.begin(), all.end(), -1), all.end());
    if (all.empty()) return kUnknown;
    bool matched = false;
    for (const int d : all) {
        const int column = x - min_px - rounded(d, 16);
        if (d - matches.nearest.at_or(column, y, kAnything) > 16) continue;
        visible.push_back(d);
        matched = matched || agreed(d, matches.right, column, y, 16) != kUnknown;
    }
    if (visible.empty()) return *std::min_element(all.begin(), all.end());
    std::sort(visible.begin(), visible.end());
    if (matched) return median(visible);
    const auto is_hidden = [&](int d) {
        const int nearest = matches.nearest.at_or(x - min_px - rounded(d, 16), y, kAnything);
        return nearest != kAnything && nearest - d > 16;
    };
    if (is_hidden(visible[0])) {
        for (const int d : visible)
            if (is_hidden(d) && std::find(others.begin(), others.end(), d) != others.end()) return d;
        return visible[0];
    }
    return most_alike(visible, pictures, x, y, min_px);
}

// Returns the weight of a filled pixel as a voter.
int voter_weight(const Trusted& matches, const Pictures& pictures, int disparity, int x, int y, int min_px) {
    const int position = 16 * (x - min_px) - disparity;
    if (position < 8) return 3;
    if (pictures.left.channels.size() == 1 || disparity == kUnknown) return 1;
    if (position > 16 * (pictures.left.grey.width - 1)) return 1;
    const int nearest = matches.nearest.at(x - min_px - rounded(disparity, 16), y);
    if (nearest != kAnything && std::abs(nearest - disparity) > 16) return 1;
    return window_difference(pictures, x, y, position) <= 135 ? 4 : 1;
}

bool known_around(const Grid& map, int x, int y) {
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
            if (map.at_or(x + i, y + j, kUnknown) == kUnknown) return false;
    return true;
}

void add_half_size(const HalfSize& half_size, int min_px, Trusted& matches) {
    for (int y = 0; y < matches.left.height; ++y)
        for (int x = 0; x < matches.left.width; ++x) {
            if (matches.left.at(x, y) != kUnknown || !known_around(half_size.left, x / 2, y / 2)) continue;
            const double disparity_px = 2 * (half_size.min_px + half_size.left.at(x / 2, y / 2) / 16.0);
            const int d = static_cast<int>(16 * (disparity_px - min_px));
            const int column = x - min_px - rounded(d, 16);
            if (d < 0 || column < 0 || column >= matches.left.width) continue;
            const int right = matches.right.at(column, y);
            if (right == kUnknown || std::abs(right - d) <= 24) matches.left.at(x, y) = d;
        }
}

}  // namespace

Grid medians(const Grid& map) {
    Grid result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            std::vector<int> values;
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i) {
                    const int value = map.at_or(x + i, y + j, kUnknown);
                    values.push_back(value == kUnknown ? map.at(x, y) : value);
                }
            result.at(x, y) = median(values);
        }
    return result;
}

Trusted trusted_matches(const Views& winners, const Settings& settings) {
    const Views views{medians(winners.left), medians(winners.right)};
    const int width = views.left.width, height = views.left.height;
    Trusted result{views.left, views.right, Grid(width, height, kAnything)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int d = views.left.at(x, y);
            const int column = x - settings.min_px - rounded(d, 16);
            if (settings.limit >= 0) result.left.at(x, y) = agreed(d, views.right, column, y, settings.limit);
        }
    if (settings.speckle_pixels > 0) remove_speckles(result.left, settings);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int d = views.right.at(x, y);
            const int column = x + settings.min_px + rounded(d, 16);
            result.right.at(x, y) =
                agreed(d, result.left, column, y, settings.limit < 0 ? 16 : settings.limit);
        }
    for (int y = 0; y < height; ++y)
        for (int x = 1; x + 1 < width; ++x) {
            const int a = result.right.at(x - 1, y), b = result.right.at(x, y), c = result.right.at(x + 1, y);
            if (a != kUnknown && b != kUnknown && c != kUnknown)
                result.nearest.at(x, y) = std::max({a, b, c});
        }
    return result;
}

Planes slopes(const Grid& map, int stride) {
    Planes lines{map, map}, means{Grid(map.width, map.height, 0), Grid(map.width, map.height, 0)};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            lines.x.at(x, y) = line_slope(map, x, y, 1, 0);
            lines.y.at(x, y) = line_slope(map, x, y, 0, 1);
        }
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if (map.at(x, y) == kUnknown) continue;
            means.x.at(x, y) = window_mean(map, lines.x, stride, x, y);
            means.y.at(x, y) = window_mean(map, lines.y, stride, x, y);
        }
    return means;
}

Grid fill(const Trusted& matches, const Planes& slopes, const Pictures& pictures, int min_px) {
    Grid result = matches.left;
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            if (matches.left.at(x, y) == kUnknown)
                result.at(x, y) = filled(matches, slopes, pictures, x, y, min_px);
    return result;
}

HalfSize match_at_half_size(const StereoPair& pair, const Settings& settings) {
    const Settings halved = half_settings(settings);
    return {trusted_matches(match_views(half_pair(pair), halved), halved).left, halved.min_px};
}

Result refine(const StereoPair& pair, const Views& winners, const HalfSize* half_size,
              const Settings& settings) {
    const Pictures pictures = read_pictures(pair);
    const Picture& left = pictures.left;
    Trusted matches = trusted_matches(winners, settings);
    const Grid matched = matches.left;
    constexpr int kFar = 6;
    if (half_size) add_half_size(*half_size, settings.min_px, matches);
    Grid map = fill(matches, slopes(matches.left, kFar), pictures, settings.min_px);
    raise_segments(matches.left, read_picture(pair.left, false), settings, map);
    Grid is_matched(map.width, map.height, 0), windows = near_windows(map), weights(map.width, map.height, 6);
    const auto certainty_in = [&](const Grid& of) {
        return certainty(of, pictures, matches.nearest, settings.min_px);
    };
    const Grid at_first = certainty_in(map);
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        is_matched.values[i] = matched.values[i] != kUnknown;
        const int x = static_cast<int>(i) % map.width, y = static_cast<int>(i) / map.width;
        if (is_matched.values[i] && at_first.values[i] == certain) continue;
        weights.values[i] = voter_weight(matches, pictures, map.values[i], x, y, settings.min_px);
        windows.values[i] = Window::hole;
    }
    map = votes({map, weights, matches.nearest, slopes(map, kFar), settings.min_px}, left, windows);
    for (int again = 0; again < 2; ++again) {
        weights = certainty_in(map);
        for (int& weight : weights.values) weight = weight == certain ? 6 : weight == undecided ? 2 : 1;
        map = votes({map, weights, matches.nearest, slopes(map), settings.min_px}, left, near_windows(map));
    }
    const auto with_sides = [&](const Grid& from) {
        return sides(from, pictures, matches.nearest, settings.min_px);
    };
    map = with_sides(with_sides(map));
    return {smooth(medians(map), left), is_matched};
}

}  // namespace hexrelief::matching::oracle
