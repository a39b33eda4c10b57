#include "pipeline/stages/other_views/behind_silhouettes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace hexrelief::stages {
namespace {

constexpr int kSlope_px = 8;  // pixels from which a surface's slope is taken
constexpr double kMostSlope = 0.3;
constexpr int kMixed = 1;             // pixels at the end of a surface whose colours are mixed
constexpr int kSoft_px = 2;           // averages of colours
constexpr int kLongestShare = 8;      // of a view's side
constexpr int kSmoothings = 8;        // of what continues, across the lines along which it does
constexpr double kNeighbours_px = 2;  // of two lines that continue one surface
constexpr int kSpread = 3;            // pixels beside what is shown that an atlas keeps as well
constexpr int kBorder_px = 2;
constexpr std::size_t kLeastSurface = 60;  // pixels of a surface of its own
// Pixels that nobody would miss, where the right camera sees something and where nobody does.
constexpr std::size_t kLeastRegion = 3, kLeastHidden = 30;
constexpr double kAnyStep_px = 1e9;

// A row or a column of a view, from either end.
struct Line {
    std::ptrdiff_t first, step;
    int count;
    std::size_t operator()(int i) const { return static_cast<std::size_t>(first + i * step); }
};

// What continues behind a silhouette at each pixel.
struct Continued {
    std::vector<double> disparities;      // kNotCovered = nothing
    std::vector<int> distances;           // from the silhouette, px
    std::vector<std::size_t> colours_of;  // the pixels whose colours it has

    explicit Continued(std::size_t pixels)
        : disparities(pixels, kNotCovered), distances(pixels, INT32_MAX), colours_of(pixels) {}

    // The nearest silhouette decides; of two, the farther surface.
    void offer(std::size_t pixel, double d, int distance, std::size_t colour_of) {
        if (distance > distances[pixel] || (distance == distances[pixel] && d >= disparities[pixel])) return;
        disparities[pixel] = d;
        distances[pixel] = distance;
        colours_of[pixel] = colour_of;
    }
};

// Number of pixels of the surface that ends at line(end), at most `most`.
int reach_of(const std::vector<double>& front, const Line& line, int end, int most) {
    int reach = 1;
    while (reach < most && end - reach >= 0 &&
           std::abs(front[line(end - reach)] - front[line(end - reach + 1)]) <= kOneSurface_px)
        ++reach;
    return reach;
}

double slope_at(const std::vector<double>& front, const Line& line, int end, int reach) {
    const int span = std::min(reach - 1, kSlope_px);
    return span < 2
               ? 0
               : std::clamp((front[line(end)] - front[line(end - span)]) / span, -kMostSlope, kMostSlope);
}

// Continues each surface of the line that ends before a nearer one.
void continue_along(const std::vector<double>& front, const Line& line, double baselines, Continued& result) {
    const int longest = line.count / kLongestShare;
    for (int end = 0; end + 1 < line.count; ++end) {
        const double far = front[line(end)];
        double near = front[line(end + 1)];
        if (far == kNotCovered || near - far <= kOneSurface_px) continue;
        if (end + 2 < line.count) near = std::max(near, front[line(end + 2)]);
        const int reach = reach_of(front, line, end, longest + kSlope_px);
        const double slope = slope_at(front, line, end, reach);
        for (int k = 1; k <= longest && end + k < line.count; ++k) {
            const std::size_t pixel = line(end + k);
            const double d = std::min(far + slope * k, near);
            if (k > baselines * (near - d) + 1 || front[pixel] - d <= kOneSurface_px) break;
            result.offer(pixel, d, k, line(end - std::min(k - 1 + kMixed, reach - 1)));
        }
    }
}

Continued continued_in(const std::vector<double>& front, const ViewPlace& place, const Beyond& beyond) {
    const int width = place.width, height = place.height;
    Continued result(front.size());
    for (int y = 0; y < height; ++y) {
        const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y) * width;
        if (beyond.left > 0) continue_along(front, {row, 1, width}, beyond.left, result);
        if (beyond.right > 0) continue_along(front, {row + width - 1, -1, width}, beyond.right, result);
    }
    const std::ptrdiff_t last = static_cast<std::ptrdiff_t>(height - 1) * width;
    for (int x = 0; x < width; ++x) {
        if (beyond.up > 0) continue_along(front, {x, width, height}, beyond.up, result);
        if (beyond.down > 0) continue_along(front, {last + x, -width, height}, beyond.down, result);
    }
    return result;
}

std::vector<std::size_t> pixels_of(const Continued& continued) {
    std::vector<std::size_t> pixels;
    for (std::size_t i = 0; i < continued.disparities.size(); ++i)
        if (continued.disparities[i] != kNotCovered) pixels.push_back(i);
    return pixels;
}

// Calls take(i) for the neighbours i of a pixel beside, above and below it.
template <class Take>
void for_four_neighbours(std::size_t pixel, const ViewPlace& place, const Take& take) {
    const auto width = static_cast<std::size_t>(place.width);
    if (pixel % width > 0) take(pixel - 1);
    if (pixel % width + 1 < width) take(pixel + 1);
    if (pixel >= width) take(pixel - width);
    if (pixel + width < width * place.height) take(pixel + width);
}

// Makes lines that continue one surface agree.
void smooth(Continued& continued, const std::vector<double>& front, const ViewPlace& place) {
    const std::vector<std::size_t> pixels = pixels_of(continued);
    std::vector<double>& disparities = continued.disparities;
    std::vector<double> smoothed(pixels.size());
    for (int round = 0; round < kSmoothings; ++round) {
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const double own = disparities[pixels[i]];
            double sum = own;
            int count = 1;
            for_four_neighbours(pixels[i], place, [&](std::size_t other) {
                const double d = disparities[other] == kNotCovered ? front[other] : disparities[other];
                if (std::abs(d - own) > kNeighbours_px) return;
                sum += d;
                ++count;
            });
            smoothed[i] = sum / count;
        }
        for (std::size_t i = 0; i < pixels.size(); ++i) disparities[pixels[i]] = smoothed[i];
    }
}

// Extends the colours over pixels that hide what continues, so that a texture's filter finds no others there.
void spread_colours(Continued& continued, const OtherView& view, const std::vector<double>& front) {
    std::vector<std::size_t> pixels = pixels_of(continued);
    for (int round = 0; round < kSpread; ++round)
        for (std::size_t from : std::exchange(pixels, {}))
            for_four_neighbours(from, view.place, [&](std::size_t i) {
                if (continued.disparities[i] != kNotCovered || DisparityMap::known(view.missing.values[i]) ||
                    front[i] - continued.disparities[from] <= kOneSurface_px)
                    return;
                continued.disparities[i] = continued.disparities[from];
                continued.colours_of[i] = continued.colours_of[from];
                pixels.push_back(i);
            });
}

// Paints what continues into a picture of any size, in colours averaged over the pixels of one surface around
// each: lines that continue beside each other have colours from different distances.
void paint(Image& picture, const ViewPlace& place, const Continued& continued) {
    if (picture.empty()) return;
    const Image before = picture;
    const auto column = [&](int x) { return x * picture.width / place.width; };
    const auto row = [&](int y) { return y * picture.height / place.height; };
    const auto width = static_cast<std::size_t>(place.width);
    for (const std::size_t pixel : pixels_of(continued)) {
        const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
        if (column(x) == column(x + 1) || row(y) == row(y + 1))
            continue;  // a smaller picture has no such pixel
        int sums[4] = {}, count = 0;
        for (int v = std::max(0, y - kSoft_px); v <= std::min(place.height - 1, y + kSoft_px); ++v)
            for (int u = std::max(0, x - kSoft_px); u <= std::min(place.width - 1, x + kSoft_px); ++u) {
                const std::size_t other = v * width + u;
                if (!(std::abs(continued.disparities[other] - continued.disparities[pixel]) <=
                      kNeighbours_px))
                    continue;
                const std::size_t from = continued.colours_of[other];
                const std::uint8_t* const color =
                    before.at(column(static_cast<int>(from % width)), row(static_cast<int>(from / width)));
                for (int c = 0; c < picture.channels; ++c) sums[c] += color[c];
                ++count;
            }
        for (int v = row(y); v < row(y + 1); ++v)
            for (int u = column(x); u < column(x + 1); ++u)
                for (int c = 0; c < picture.channels; ++c)
                    picture.at(u, v)[c] = static_cast<std::uint8_t>((sums[c] + count / 2) / count);
    }
}

// Calls take(i) for the neighbours i of a pixel, in the order of rows.
template <class Take>
void for_neighbours(const DisparityMap& map, std::size_t pixel, const Take& take) {
    const int x = static_cast<int>(pixel % map.width), y = static_cast<int>(pixel / map.width);
    for (int v = std::max(0, y - 1); v <= std::min(map.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(map.width - 1, x + 1); ++u)
            take(static_cast<std::size_t>(v) * map.width + u);
}

// Returns the pixels of those regions that have fewer than `least` pixels. Neighbours that differ by more
// than `step_px` are in two regions.
std::vector<std::size_t> specks_of(const DisparityMap& map, std::size_t least, double step_px) {
    std::vector<char> visited(map.values.size());
    std::vector<std::size_t> region, specks;
    for (std::size_t seed = 0; seed < map.values.size(); ++seed) {
        if (visited[seed] || !DisparityMap::known(map.values[seed])) continue;
        region.assign(1, seed);
        visited[seed] = 1;
        for (std::size_t next = 0; next < region.size(); ++next)
            for_neighbours(map, region[next], [&](std::size_t i) {
                if (visited[i] || !(std::abs(map.values[i] - map.values[region[next]]) <= step_px)) return;
                visited[i] = 1;
                region.push_back(i);
            });
        if (region.size() < least) specks.insert(specks.end(), region.begin(), region.end());
    }
    return specks;
}

// Gives small regions to the surfaces around them. Those alone stay, unless nobody would miss them.
void merge_specks(DisparityMap& map) {
    const DisparityMap before = map;
    std::vector<std::size_t> open = specks_of(map, kLeastSurface, kOneSurface_px);
    for (const std::size_t i : open) map.values[i] = kUnknownDisparity;
    for (std::size_t left = open.size() + 1; left > open.size();) {
        left = open.size();
        const DisparityMap round = map;
        std::erase_if(open, [&](std::size_t pixel) {
            float& d = map.values[pixel];
            for_neighbours(map, pixel, [&](std::size_t i) { d = std::min(d, round.values[i]); });
            return DisparityMap::known(d);
        });
    }
    for (const std::size_t i : open) map.values[i] = before.values[i];
    for (const std::size_t i : specks_of(map, kLeastRegion, kOneSurface_px))
        map.values[i] = kUnknownDisparity;
}

// Adds the covered pixels beside the known ones that lie on the same surface.
void grow(DisparityMap& map, const std::vector<double>& covered) {
    const DisparityMap before = map;
    for (std::size_t i = 0; i < covered.size(); ++i) {
        if (covered[i] == kNotCovered || DisparityMap::known(before.values[i])) continue;
        bool joins = false;
        for_neighbours(before, i, [&](std::size_t j) {
            joins |= std::abs(before.values[j] - covered[i]) <= kOneSurface_px;
        });
        if (joins) map.values[i] = static_cast<float>(covered[i]);
    }
}

}  // namespace

void continue_behind(OtherView& view, const SeenSurface& here, const Beyond& beyond,
                     const VisibleSurface& visible, int threads) {
    const ViewPlace& place = view.place;
    std::vector<double> front = here.disparities;
    for (std::size_t i = 0; i < front.size(); ++i)
        if (DisparityMap::known(view.missing.values[i])) front[i] = view.missing.values[i];
    Continued continued = continued_in(front, place, beyond);
    for (std::size_t i = 0; i < front.size(); ++i)
        if (DisparityMap::known(view.missing.values[i])) continued.disparities[i] = kNotCovered;
    smooth(continued, front, place);
    for_row_bands(place.height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < place.width; ++x) {
                const std::size_t pixel = static_cast<std::size_t>(y) * place.width + x;
                if (continued.disparities[pixel] == kNotCovered) continue;
                const float d = behind({x + 0.5, y + 0.5, continued.disparities[pixel]}, place, visible);
                view.missing.values[pixel] = view.map.values[pixel] = d;
            }
    });
    for (const std::size_t i : specks_of(view.missing, kLeastHidden, kAnyStep_px))
        if (continued.disparities[i] != kNotCovered) view.missing.values[i] = kUnknownDisparity;
    spread_colours(continued, view, front);
    paint(view.color, place, continued);
    paint(view.picture, place, continued);
}

void join_to_surface(OtherView& view, const SeenSurface& here) {
    merge_specks(view.missing);
    for (int px = 0; px < kBorder_px; ++px) grow(view.missing, here.disparities);
}

}  // namespace hexrelief::stages
