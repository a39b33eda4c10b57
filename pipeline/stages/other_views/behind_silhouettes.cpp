#include "pipeline/stages/other_views/behind_silhouettes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "pipeline/base/thread_pool.h"
#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/data/color_difference.h"
#include "pipeline/data/four_neighbours.h"
#include "pipeline/data/line_of_map.h"
#include "pipeline/stages/other_views/backing_texture.h"
#include "pipeline/stages/other_views/continued.h"
#include "pipeline/stages/other_views/small_regions.h"
#include "pipeline/stages/other_views/texture_synthesis.h"

namespace hexrelief::stages {
namespace {

constexpr int kSlope_px = 8;  // pixels from which a surface's slope is taken
constexpr double kMostSlope = 0.3;
constexpr int kMixed = Beyond::kMixed_px;  // pixels at the end of a surface whose colours are mixed
// What continues is no longer than this share of a view's side, with colours from the last.
constexpr int kLongestShare = 16, kMirroredShare = 40;
constexpr int kApart = 2;      // times its width: a baseline on, mixed pixels stand apart from their thing
constexpr int kRatherFar = 2;  // times less unlike the farther surface than the nearer one: not mixed of both
// What looks this unlike a surface: levels, and times the mean deviation of its colours from their mean.
constexpr double kUnlike = 16, kUnlikeDeviations = 1.5;
constexpr int kWithinEdge_px = 2;         // of a nearer surface: so far a match errs
constexpr std::size_t kLeastHidden = 30;  // pixels that nobody would miss where nobody sees anything
constexpr double kAnyStep_px = 1e9;
constexpr int kSpread_px = 16;  // beside what is shown that has its colours: triangles reach hardly beyond 12

// What the colours of a pixel are of. An outline is a narrow line unlike the surface that it seems to end.
enum class Purity : std::uint8_t { clean, mixed, of_nearer, outline };

// A side of a view: how far beyond it the outermost camera stands, and Beyond::mixed_px.
struct Side {
    double baselines;
    int mixed_px;
    bool is_photograph() const { return mixed_px > kMixed; }
};

// Looks at more pixels of the surface that ends at line(end), of which `reach` are known. Returns their
// number, at most `most`.
int reach_of(const Disparities& front, const LineOfMap& line, int end, int reach, int most) {
    while (reach < most && end - reach >= 0 &&
           std::abs(front[line(end - reach)] - front[line(end - reach + 1)]) <= kOneSurface_px)
        ++reach;
    return reach;
}

double slope_at(const Disparities& front, const LineOfMap& line, int end, int span) {
    if (span < 2) return 0;
    return std::clamp((front[line(end)] - front[line(end - span)]) / span, -kMostSlope, kMostSlope);
}

// Returns the number of pixels at the end of a surface, at most `most` and one, that are mixed of it and the
// nearer surface, at line(near). reach: the number of this one's pixels.
int mixed_at(const Image& picture, const LineOfMap& line, int end, int near, int reach, int most) {
    if (picture.empty() || near >= line.count) return kMixed;
    const auto difference = [&](int i, int j) { return color_difference(picture, line(i), line(j)); };
    const int far = end - std::min(reach - 1, most + kMixed);
    int last = std::max(end - most, far);
    while (last <= end - kMixed && difference(last, near) >= kRatherFar * difference(last, far)) ++last;
    return end - last + 1;
}

// Returns where the nearer surface in front of line(end) begins: behind pixels that are mixed.
int nearest_after(const Disparities& front, const LineOfMap& line, int end, int mixed_px) {
    int nearest = end + 1;
    const int last = std::min(line.count - 1, end + 1 + (mixed_px > kMixed ? mixed_px : 1));
    for (int i = end + 2; i <= last; ++i)
        if (front[line(i)] > front[line(nearest)]) nearest = i;
    return nearest;
}

// Returns the place from first to last that mirrors at both lead to, from a place behind first on.
int folded(int place, int first, int last) {
    const int length = last - first;
    if (length <= 0) return last;
    const int along = (place - first) % (2 * length);
    return first + std::min(along, 2 * length - along);
}

// The mean colour of a few pixels of a line from `first` on, and how far they are from it in the mean.
struct MeanColour {
    std::array<double, 3> levels = {};
    double deviation = 0;

    MeanColour(const Image& picture, const LineOfMap& line, int first, int count) {
        for (int i = first; i < first + count; ++i)
            for (int c = 0; c < picture.channels; ++c)
                levels[c] += picture.pixels[line(i) * picture.channels + c] / static_cast<double>(count);
        for (int i = first; i < first + count; ++i) deviation += difference(picture, line(i)) / count;
    }
    // Of three channels; grey ones count as three.
    double difference(const Image& picture, std::size_t pixel) const {
        double sum = 0;
        for (int c = 0; c < picture.channels; ++c)
            sum += std::abs(picture.pixels[pixel * picture.channels + c] - levels[c]);
        return sum * 3 / picture.channels;
    }
};

// Marks the narrow line at the end of the surface at line(end), if there is one, whose colours are unlike the
// surface's behind it. A wider strip may be the surface's own.
void mark_outline(const Disparities& front, const Image& picture, const LineOfMap& line, int end, int most,
                  std::vector<Purity>& colours) {
    const int narrow = most / 2, looked_at = narrow + kMixed, reach = reach_of(front, line, end, 1, 2 * most);
    if (picture.empty() || reach < looked_at + kMixed) return;
    const MeanColour behind(picture, line, end - reach + 1, reach - looked_at);
    int last = end + 1;
    for (int i = end; i > end - looked_at; --i)
        if (behind.difference(picture, line(i)) > kUnlike + kUnlikeDeviations * behind.deviation) last = i;
    if (last <= end && last > end - narrow)
        for (int i = end; i >= last - 1; --i) colours[line(i)] = Purity::outline;
}

// Marks the pixels at the end of the surface at line(end) whose colours are mixed.
void mark_mixed(const Disparities& front, const Image& picture, const LineOfMap& line, int end, int most,
                std::vector<Purity>& colours) {
    const int near = nearest_after(front, line, end, most) + kMixed,
              reach = reach_of(front, line, end, 1, most + kMixed + 1),
              mixed = std::min(reach, mixed_at(picture, line, end, near, reach, most));
    const auto difference = [&](int i, int j) { return color_difference(picture, line(i), line(j)); };
    const bool is_compared = !picture.empty() && near < line.count && mixed < reach;
    for (int i = end; i > end - mixed; --i) {
        const bool is_of_nearer =
            mixed == reach ||
            (is_compared && difference(i, near) < kRatherFar * difference(i, end - reach + 1));
        colours[line(i)] = std::max(colours[line(i)], is_of_nearer ? Purity::of_nearer : Purity::mixed);
    }
    mark_outline(front, picture, line, end, most, colours);
}

// Continues the surface that ends at line(end) before a nearer one.
// missing: what is known there stays, and nothing continues behind it.
void continue_from(const Disparities& front, const std::vector<Purity>& colours, const DisparityMap& missing,
                   const LineOfMap& line, int end, Side side, Continued& result) {
    const bool is_photograph = side.is_photograph();
    const int longest = line.count / kLongestShare, mirrored = line.count / kMirroredShare;
    const double far = front[line(end)];
    const int nearest = nearest_after(front, line, end, side.mixed_px);
    const double near = front[line(nearest)];
    int reach = reach_of(front, line, end, 1, std::max(kSlope_px, side.mixed_px + kMixed) + 1);
    // A narrow surface in front of a farther one is mixed of that and the nearer one.
    if (is_photograph && reach <= side.mixed_px && end >= reach &&
        far - front[line(end - reach)] > kOneSurface_px)
        return;
    // A slope goes on for as far as it was seen.
    const int span = std::min(reach - 1, kSlope_px);
    const double slope = slope_at(front, line, end, span);
    int mixed = is_photograph ? 0 : kMixed;
    while (is_photograph && mixed < reach && colours[line(end - mixed)] != Purity::clean) {
        ++mixed;
        reach = reach_of(front, line, end, reach, std::min(mirrored, mixed) + kMixed);
    }
    const bool has_colours = !is_photograph || mixed < reach;
    // Outlines and pixels of the nearer surface's colours get clean ones as well. Those farther away are
    // beside another silhouette.
    const int own = std::min(mixed, side.mixed_px + 1);
    for (int k = 0; is_photograph && k < own; ++k)
        if (const std::size_t pixel = line(end - k);
            colours[pixel] == Purity::outline ||
            (colours[pixel] == Purity::of_nearer && near - far > kApart * own))
            result.offer(
                pixel, front[pixel], 0,
                has_colours ? line(end - folded(2 * mixed - k, mixed, reach - 1)) : Continued::kNoColour);
    for (int k = 1; k <= longest && end + k < line.count; ++k) {
        const std::size_t pixel = line(end + k);
        const double d = std::min(far + slope * std::min(k, span), near);
        if (k > side.baselines * (near - d) + 1 || front[pixel] - d <= kOneSurface_px) break;
        if (DisparityMap::known(missing.values[pixel])) continue;
        if (!has_colours) {
            result.offer(pixel, d, k, Continued::kNoColour);
            continue;
        }
        reach = reach_of(front, line, end, reach, std::min(k, mirrored) + mixed);
        result.offer(pixel, d, k, line(end - folded(k - 1 + mixed, mixed, reach - 1)));
    }
}

// Calls take(line, end) for each surface that ends at line(end) before a nearer one, in some lines beside
// each other. They are walked together, because a column's pixels are far apart in memory.
template <class Take>
void for_silhouettes(const Disparities& front, const LineOfMap& first, std::ptrdiff_t beside,
                     std::size_t lines, const Take& take) {
    for (int end = 0; end + 1 < first.count; ++end)
        for (std::size_t k = 0; k < lines; ++k) {
            const LineOfMap line{first.first + static_cast<std::ptrdiff_t>(k) * beside, first.step,
                                 first.count};
            const double far = front[line(end)];
            if (far != kNotCovered && front[line(end + 1)] - far > kOneSurface_px) take(line, end);
        }
}

// Calls take(line, end, baselines) for all silhouettes of a view, from the sides beyond which cameras stand.
template <class Take>
void for_silhouettes(const Disparities& front, int width, int height, const Beyond& beyond, ThreadPool& pool,
                     const Take& take) {
    const auto walk = [&](double baselines, const LineOfMap& first, std::ptrdiff_t beside,
                          std::size_t lines) {
        if (baselines > 0)
            for_silhouettes(front, first, beside, lines,
                            [&](const LineOfMap& line, int end) { take(line, end, baselines); });
    };
    pool.parallel_for_chunks(static_cast<std::size_t>(height), [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y) * width;
            walk(beyond.left, {row, 1, width}, 0, 1);
            walk(beyond.right, {row + width - 1, -1, width}, 0, 1);
        }
    });
    pool.parallel_for_chunks(static_cast<std::size_t>(width), [&](std::size_t begin, std::size_t end) {
        const auto top = static_cast<std::ptrdiff_t>(begin);
        walk(beyond.up, {top, width, height}, 1, end - begin);
        walk(beyond.down, {top + static_cast<std::ptrdiff_t>(height - 1) * width, -width, height}, 1,
             end - begin);
    });
}

Continued continued_in(const Disparities& front, const OtherView& view, const Beyond& beyond,
                       ThreadPool& pool) {
    const int width = view.place.width, height = view.place.height;
    const bool is_photograph = Side{0, beyond.mixed_px}.is_photograph();
    std::vector<Purity> colours(is_photograph ? front.size() : 0, Purity::clean);
    if (is_photograph)
        for_silhouettes(front, width, height, {1, 1, 1, 1}, pool,
                        [&](const LineOfMap& line, int end, double) {
                            mark_mixed(front, view.color, line, end, beyond.mixed_px, colours);
                        });
    Continued result(front.size());
    pool.parallel_for(front.size(), [&](std::size_t begin, std::size_t end) {
        std::fill(result.disparities.begin() + static_cast<std::ptrdiff_t>(begin),
                  result.disparities.begin() + static_cast<std::ptrdiff_t>(end), kNotCovered);
    });
    for_silhouettes(
        front, width, height, beyond, pool, [&](const LineOfMap& line, int end, double baselines) {
            continue_from(front, colours, view.missing, line, end, {baselines, beyond.mixed_px}, result);
        });
    for (std::size_t i = 0; i < front.size(); ++i)
        if (result.disparities[i] != kNotCovered) result.pixels.push_back(static_cast<std::uint32_t>(i));
    result.is_mixed.resize(colours.size());
    std::ranges::transform(colours, result.is_mixed.begin(),
                           [](Purity colour) { return colour != Purity::clean; });
    return result;
}

// Adds the covered pixels within border_px of the known ones that lie on the same surface.
void grow(DisparityMap& map, const Disparities& covered, int border_px, ThreadPool& pool) {
    const auto add_beside = [&](std::uint32_t from, std::vector<std::uint32_t>& beside) {
        for_neighbours(map, from, [&](std::uint32_t i) {
            if (covered[i] != kNotCovered && !DisparityMap::known(map.values[i]) &&
                std::abs(map.values[from] - covered[i]) <= kOneSurface_px)
                beside.push_back(i);
        });
    };
    std::vector<std::vector<std::uint32_t>> found(static_cast<std::size_t>(pool.size()));
    pool.run([&](int thread) {
        const std::size_t end = pool.share(map.values.size(), thread + 1);
        for (std::size_t i = pool.share(map.values.size(), thread); i < end; ++i)
            if (DisparityMap::known(map.values[i])) add_beside(static_cast<std::uint32_t>(i), found[thread]);
    });
    for (int px = 1;; ++px) {
        std::vector<std::uint32_t> border;
        for (const std::vector<std::uint32_t>& beside : found)
            for (const std::uint32_t i : beside)
                if (!DisparityMap::known(map.values[i])) {
                    map.values[i] = static_cast<float>(covered[i]);
                    border.push_back(i);
                }
        if (px == border_px) return;
        found.assign(1, {});
        for (const std::uint32_t from : border) add_beside(from, found[0]);
    }
}

}  // namespace

Behind continue_behind(OtherView& view, const SeenSurface& here, const Beyond& beyond,
                       const VisibleSurface& visible, int threads) {
    const ViewPlace& place = view.place;
    ThreadPool pool(threads);
    Disparities front(here.disparities.size());
    DisparityMap merged;
    if (beyond.mixed_px > kMixed && std::ranges::any_of(view.missing.values, DisparityMap::known)) {
        merged = view.missing;
        merge_specks(merged);
        for (const std::uint32_t i : cracks_of(view.missing, here.disparities))
            view.missing.values[i] = kUnknownDisparity;
    }
    const std::vector<float>& added = merged.values.empty() ? view.missing.values : merged.values;
    pool.parallel_for(front.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            front[i] = DisparityMap::known(added[i]) ? added[i] : here.disparities[i];
    });
    Continued continued = continued_in(front, view, beyond, pool);
    if (beyond.mixed_px > kMixed)
        give_scraps_away(continued, front, place, std::max(place.width, place.height) / kLongestShare, pool);
    smooth(continued, front, place, pool);
    pool.parallel_for_chunks(continued.pixels.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t pixel = continued.pixels[i];
            if (continued.distances[pixel] == 0) continue;
            const int x = static_cast<int>(pixel % place.width), y = static_cast<int>(pixel / place.width);
            view.missing.values[pixel] =
                behind({x + 0.5, y + 0.5, continued.disparities[pixel]}, place, visible);
        }
    });
    for (const std::uint32_t i : specks_of(view.missing, kLeastHidden, kAnyStep_px))
        if (continued.disparities[i] != kNotCovered && continued.distances[i] > 0)
            view.missing.values[i] = kUnknownDisparity;
    spread_colours(continued, view.missing, front, kSpread_px);
    return {std::move(continued), std::move(front)};
}

void paint_behind(OtherView& view, Behind hidden, OtherView* backing, int threads) {
    const ViewPlace& place = view.place;
    auto& [continued, front] = hidden;
    ThreadPool pool(threads);
    Image& texture = view.picture.empty() ? view.color : view.picture;
    Continued behind = backing ? backing_behind(continued, *backing, front, place, pool) : Continued(0);
    Image painted = with_texture(texture, place, continued, front, pool);
    paint(painted, texture, place, continued, pool);
    texture = std::move(painted);
    if (backing) paint_backing(*backing, texture, place, std::move(behind), front, pool);
}

void join_to_surface(OtherView& view, const SeenSurface& here, int border_px, std::size_t least,
                     int threads) {
    merge_specks(view.missing, least);
    ThreadPool pool(threads);
    grow(view.missing, here.disparities, border_px, pool);
}

}  // namespace hexrelief::stages
