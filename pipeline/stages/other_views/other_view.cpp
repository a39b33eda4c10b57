#include "pipeline/stages/other_views/other_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace hexrelief::stages {
namespace {

constexpr double kAgree_px = 1;  // as neighbours of one surface (SurfaceConfig::least_discontinuity_px)
// Pixels that nobody would miss, where the right camera sees something and where nobody does.
constexpr std::size_t kLeastSeen = 3, kLeastHidden = 12;
constexpr int kSlope_px = 8;  // pixels from which a surface's slope is taken
constexpr double kMostSlope = 0.3;
constexpr int kSpread = 12;  // pixels
constexpr int kMixed = 1;    // pixels at the end of a surface whose colours are mixed

Image mirrored(const Image& image) {
    Image result = image;
    const auto flip = [&](std::vector<std::uint8_t>& values, int channels) {
        const auto row = static_cast<std::size_t>(image.width) * channels;
        for (std::size_t begin = 0; begin < values.size(); begin += row)
            for (int x = 0; x < image.width / 2; ++x)
                std::swap_ranges(&values[begin + x * channels], &values[begin + x * channels] + channels,
                                 &values[begin + (image.width - 1 - x) * channels]);
    };
    flip(result.pixels, image.channels);
    flip(result.alpha, 1);
    return result;
}

DisparityMap unknown_map(int width, int height) {
    return {width, height, std::vector<float>(static_cast<std::size_t>(width) * height, kUnknownDisparity)};
}

// Makes regions of fewer than `least` connected known pixels unknown.
void drop_specks(DisparityMap& map, std::size_t least) {
    std::vector<char> visited(map.values.size());
    std::vector<std::size_t> region;
    for (std::size_t seed = 0; seed < map.values.size(); ++seed) {
        if (visited[seed] || !DisparityMap::known(map.values[seed])) continue;
        region.assign(1, seed);
        visited[seed] = 1;
        for (std::size_t next = 0; next < region.size(); ++next) {
            const int x = static_cast<int>(region[next] % map.width),
                      y = static_cast<int>(region[next] / map.width);
            for (int v = std::max(0, y - 1); v <= std::min(map.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(map.width - 1, x + 1); ++u) {
                    const std::size_t i = static_cast<std::size_t>(v) * map.width + u;
                    if (visited[i] || !DisparityMap::known(map.values[i])) continue;
                    visited[i] = 1;
                    region.push_back(i);
                }
        }
        if (region.size() < least)
            for (const std::size_t i : region) map.values[i] = kUnknownDisparity;
    }
}

// Returns the open pixels, and the covered pixels beside them that lie on the same surface.
DisparityMap with_border(const DisparityMap& open, const std::vector<double>& covered) {
    DisparityMap result = open;
    for (int y = 0; y < open.height; ++y)
        for (int x = 0; x < open.width; ++x) {
            const double d = covered[static_cast<std::size_t>(y) * open.width + x];
            if (d == kNotCovered) continue;
            bool joins = false;
            for (int v = std::max(0, y - 1); v <= std::min(open.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(open.width - 1, x + 1); ++u)
                    joins |= std::abs(open.at(u, v) - d) <= kAgree_px;
            if (joins) result.at(x, y) = static_cast<float>(d);
        }
    return result;
}

// A row or a column of a view.
struct Line {
    std::size_t first, step;
    int count;
    std::size_t operator()(int i) const { return first + static_cast<std::size_t>(i) * step; }
};

// The surface beside a gap that continues in it.
struct FarSide {
    int end;           // its last pixel before the gap
    int away;          // step from there away from the gap: -1 or 1
    int reach = 1;     // pixels of it from the gap on
    double slope = 0;  // px of disparity per pixel into the gap
};

FarSide far_side(const std::vector<double>& covered, const Line& line, int before, int after) {
    const bool is_before = covered[line(before)] <= covered[line(after)];
    FarSide side{is_before ? before : after, is_before ? -1 : 1};
    const auto at = [&](int k) { return side.end + k * side.away; };
    const int gap = after - before - 1;
    while (side.reach < std::max(gap, kSlope_px) && at(side.reach) >= 0 && at(side.reach) < line.count &&
           std::abs(covered[line(at(side.reach))] - covered[line(at(side.reach - 1))]) <= kAgree_px)
        ++side.reach;
    const int span = std::min(side.reach - 1, kSlope_px);
    if (span > 1)
        side.slope =
            std::clamp((covered[line(at(0))] - covered[line(at(span))]) / span, -kMostSlope, kMostSlope);
    return side;
}

// What a view shows: the disparities that a surface covers, and colours, null where none is known.
struct Shown {
    std::vector<double> covered;
    std::vector<const std::uint8_t*> colours;
};

// Fills the gaps of a line.
void fill_gaps(Shown& shown, const Line& line, DisparityMap& gaps) {
    const std::vector<double>& covered = shown.covered;
    for (int i = 1; i < line.count; ++i) {
        if (covered[line(i)] != kNotCovered || covered[line(i - 1)] == kNotCovered) continue;
        const int before = i - 1;
        while (i < line.count && covered[line(i)] == kNotCovered) ++i;
        if (i == line.count) break;
        const FarSide side = far_side(covered, line, before, i);
        const double far = covered[line(side.end)], near = std::max(covered[line(before)], covered[line(i)]);
        for (int k = 1; k < i - before; ++k) {
            const std::size_t pixel = line(side.end - k * side.away);
            // Two ends of one surface meet.
            const double share = static_cast<double>(k) / (i - before);
            const double d =
                near - far <= kAgree_px ? far + (near - far) * share : std::min(far + side.slope * k, near);
            gaps.values[pixel] = static_cast<float>(d);
            // The last pixels of the surface have something of the nearer one's colour.
            for (int at = std::min(k + kMixed, side.reach - 1); at >= 0 && !shown.colours[pixel]; --at)
                shown.colours[pixel] = shown.colours[line(side.end + at * side.away)];
        }
    }
}

// Returns the colour of a point of the left view, from the camera that sees it.
const std::uint8_t* colour_of(const ViewPoint& in_left, const SeenPair& seen) {
    const auto at = [](const SeenSurface& surface, const Image& image,
                       const ViewPoint& p) -> const std::uint8_t* {
        const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
        if (x < 0 || x >= image.width || y < 0 || y >= image.height) return nullptr;
        const double d = surface.disparities[static_cast<std::size_t>(y) * image.width + x];
        return std::abs(d - p.d) <= kAgree_px ? image.at(x, y) : nullptr;
    };
    if (const std::uint8_t* colour = at(seen.surface.seen[0], seen.left, in_left)) return colour;
    const SeenSurface& in_right = seen.surface.seen[1];
    return at(in_right, seen.right, in_right.place.from_left(in_left));
}

// Returns the picture of these colours. Pixels without one get the mean of those around them, up to kSpread
// pixels away.
Image picture_of(const std::vector<const std::uint8_t*>& colours, int width, int height, int channels) {
    Image picture{width, height, channels, std::vector<std::uint8_t>(colours.size() * channels)};
    std::vector<int> step_of(colours.size(), 0);  // in which each pixel got its colour; -1 = none yet
    for (std::size_t i = 0; i < colours.size(); ++i)
        if (colours[i])
            std::copy_n(colours[i], channels, &picture.pixels[i * channels]);
        else
            step_of[i] = -1;
    for (int step = 1; step <= kSpread; ++step)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                int& own = step_of[static_cast<std::size_t>(y) * width + x];
                if (own >= 0) continue;
                int sums[3] = {}, count = 0;
                for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
                    for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
                        const int known = step_of[static_cast<std::size_t>(v) * width + u];
                        if (known < 0 || known == step) continue;
                        for (int c = 0; c < channels; ++c) sums[c] += picture.at(u, v)[c];
                        ++count;
                    }
                if (count == 0) continue;
                for (int c = 0; c < channels; ++c)
                    picture.at(x, y)[c] = static_cast<std::uint8_t>((sums[c] + count / 2) / count);
                own = step;
            }
    return picture;
}

}  // namespace

StereoPair mirrored(const StereoPair& pair) {
    return {mirrored(pair.right), mirrored(pair.left)};
}

DisparityMap mirrored(DisparityMap map) {
    for (int y = 0; y < map.height; ++y) {
        const auto row = map.values.begin() + static_cast<std::ptrdiff_t>(y) * map.width;
        std::reverse(row, row + map.width);
    }
    map.origins.clear();
    return map;
}

void find_missing(OtherView& view, const SurfaceMesh& mesh, const SeenSurface& in_left, int threads) {
    const SeenSurface here = see(mesh, view.place, threads);
    const DisparityMap& map = view.map;
    DisparityMap open = unknown_map(map.width, map.height);
    const auto is_open = [&](std::size_t i) {
        return here.disparities[i] == kNotCovered && DisparityMap::known(map.values[i]);
    };
    for_row_bands(map.height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * map.width;
            for (int x = 0; x < map.width; ++x) {
                const double d = map.values[row + x];
                if (!is_open(row + x)) continue;
                const ViewPoint point = view.place.to_left({x + 0.5, y + 0.5, d});
                if (point.d <= in_left.limit_at(point) + kAgree_px)
                    open.values[row + x] = map.values[row + x];
            }
            const auto beside = [&](int x) {
                if (x < 0 || x >= map.width) return kUnknownDisparity;
                const double d = here.disparities[row + x];
                return d == kNotCovered ? open.values[row + x] : static_cast<float>(d);
            };
            const auto is_wrong = [&](int x) {
                return is_open(row + x) && !DisparityMap::known(open.values[row + x]);
            };
            for (int x = 0; x < map.width; ++x) {
                if (!is_wrong(x)) continue;
                const int first = x;
                while (x + 1 < map.width && is_wrong(x + 1)) ++x;
                std::fill(&open.values[row + first], &open.values[row + x] + 1,
                          std::min(beside(first - 1), beside(x + 1)));
            }
        }
    });
    drop_specks(open, kLeastSeen);
    view.missing = with_border(open, here.disparities);
}

OtherView continued_view(const ViewPlace& place, const SurfaceMesh& mesh, const SeenPair& seen, int threads) {
    const int width = place.width, height = place.height, channels = seen.left.channels;
    Shown shown{see(mesh, place, threads).disparities, {}};
    shown.colours.resize(shown.covered.size());
    OtherView view{place, unknown_map(width, height), {}, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            if (shown.covered[i] == kNotCovered) continue;
            view.map.values[i] = static_cast<float>(shown.covered[i]);
            shown.colours[i] = colour_of(place.to_left({x + 0.5, y + 0.5, shown.covered[i]}), seen);
        }
    DisparityMap gaps = unknown_map(width, height);
    const auto row = static_cast<std::size_t>(width);
    if (place.up == 0)
        for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
            fill_gaps(shown, {y * row, 1, width}, gaps);
    else
        for (std::size_t x = 0; x < row; ++x) fill_gaps(shown, {x, row, height}, gaps);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float& d = gaps.at(x, y);
            if (!DisparityMap::known(d)) continue;
            d = behind({x + 0.5, y + 0.5, d}, place, seen.surface);
            view.map.at(x, y) = d;
        }
    drop_specks(gaps, kLeastHidden);
    view.missing = with_border(gaps, shown.covered);
    view.picture = picture_of(shown.colours, width, height, channels);
    return view;
}

}  // namespace hexrelief::stages
