#include "pipeline/stages/by_colour/bare_planes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <vector>

#include "pipeline/base/simd.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/union_find.h"
#include "pipeline/stages/by_colour/colours.h"
#include "pipeline/stages/by_colour/robust_plane.h"

namespace hexrelief::stages {
namespace {

// Levels that the means of 3x3 pixels beside a pixel, or above and below it, differ by at most on a patch.
constexpr int kMeanRadius_px = 1, kMeanOf = 9, kLargestStep = 4 * kMeanOf;
constexpr int kLeastRun_px = 3;  // in a row: narrower bridges join no patches
struct PatchLimits {
    std::size_t least_share;  // a patch has one pixel of so many of the picture's
    double matched_share;     // of a patch: beyond that it needs no plane
};
constexpr PatchLimits kOfRectified{500, 0.9}, kOfPhotographs{150, 0.4};
constexpr std::size_t kLeastSamples = 24;
constexpr int kCellsAcross = 12, kCellSamples = 6;  // a cell's side is at least kLeastCell_px
constexpr double kLeastCell_px = 4;
// What a plane needs: the share of the matches; three times that of what another plane holds of the others;
// the share of the patch's bounding box that they span, or a larger one of the box of what both cameras see,
// if that is not too little of the patch; and at most this share of the pixels more where the colours fit
// worse by kWorse levels than where they fit better.
constexpr double kHeldShare = 0.5, kOfSecond = 3, kSpannedShare = 0.75, kSpannedOfSeen = 0.9,
                 kSeenShare = 0.5, kWorseShare = 0.004;
constexpr float kWorse = 4, kHidden_px = 1.5f;
constexpr std::size_t kColorSamples = 4000;

struct Run {
    int y, first, end;
};
struct Patch {
    std::vector<Run> runs;  // in the order of rows and columns
    std::size_t pixels = 0;
};

HEXRELIEF_SMALL_VECTORS void find_steps(const std::int16_t* __restrict above,
                                        const std::int16_t* __restrict own,
                                        const std::int16_t* __restrict below, int count, int channels,
                                        std::int16_t* __restrict steps) {
    for (int i = channels; i < count - channels; ++i) {
        const auto across = static_cast<std::int16_t>(std::abs(own[i + channels] - own[i - channels]));
        const auto down = static_cast<std::int16_t>(std::abs(below[i] - above[i]));
        steps[i] = across > down ? across : down;
    }
}

template <int channels>
HEXRELIEF_SMALL_VECTORS void find_bare(const std::int16_t* __restrict steps, int width,
                                       std::uint8_t* __restrict is_bare) {
    for (int x = 0; x < width; ++x) {
        std::int16_t most = steps[x * channels];
        for (int c = 1; c < channels; ++c)
            most = most > steps[x * channels + c] ? most : steps[x * channels + c];
        is_bare[x] = most < kLargestStep;
    }
}

// Returns the runs of bare pixels of each row. The outermost columns belong to the pixels beside them.
std::vector<std::vector<Run>> bare_runs(const cv::Mat& sums, ThreadPool& pool) {
    const int width = sums.cols, height = sums.rows, channels = sums.channels(), count = width * channels;
    std::vector<std::vector<Run>> runs(static_cast<std::size_t>(height));
    pool.parallel_for(runs.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<std::int16_t> steps(static_cast<std::size_t>(count));
        std::vector<std::uint8_t> is_bare(static_cast<std::size_t>(width));
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
            const auto row = [&](int at) { return sums.ptr<std::int16_t>(std::clamp(at, 0, height - 1)); };
            find_steps(row(y - 1), row(y), row(y + 1), count, channels, steps.data());
            std::copy_n(&steps[channels], channels, steps.data());
            std::copy_n(&steps[count - 2 * channels], channels, &steps[count - channels]);
            (channels == 1 ? find_bare<1> : find_bare<3>)(steps.data(), width, is_bare.data());
            for (int x = 0; x < width; ++x) {
                if (!is_bare[x]) continue;
                const int first = x;
                while (x < width && is_bare[x]) ++x;
                if (x - first >= kLeastRun_px) runs[y].push_back({y, first, x});
            }
        }
    });
    return runs;
}

std::vector<Patch> find_patches(const cv::Mat& sums, std::size_t least_share, ThreadPool& pool) {
    const std::vector<std::vector<Run>> rows = bare_runs(sums, pool);
    std::vector<Run> runs;
    std::size_t above = 0;
    UnionFind sets;
    for (const std::vector<Run>& row : rows) {
        const std::size_t first = runs.size();
        for (const Run& run : row) {
            while (above < first && runs[above].end <= run.first) ++above;
            sets.add();
            for (std::size_t other = above; other < first && runs[other].first < run.end; ++other)
                sets.join(static_cast<std::uint32_t>(other), static_cast<std::uint32_t>(runs.size()));
            runs.push_back(run);
        }
        above = first;
    }
    std::vector<std::size_t> pixels(runs.size()), patch_of(runs.size());
    for (std::size_t i = 0; i < runs.size(); ++i)
        pixels[sets.find(static_cast<std::uint32_t>(i))] +=
            static_cast<std::size_t>(runs[i].end - runs[i].first);
    const std::size_t all = sums.total();
    std::vector<Patch> patches;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const std::size_t root = sets.find(static_cast<std::uint32_t>(i));
        if (pixels[root] * least_share < all) continue;
        if (root == i) {
            patch_of[i] = patches.size();
            patches.push_back({{}, pixels[i]});
        }
        patches[patch_of[root]].runs.push_back(runs[i]);
    }
    return patches;
}

// Returns the nearest match that the right camera sees at each of its pixels, -1 = none.
std::vector<float> nearest_matches(const DisparityMap& map, ThreadPool& pool) {
    std::vector<float> nearest(map.values.size(), -1);
    pool.parallel_for_each(map.height, [&](int y) {
        const std::size_t row = static_cast<std::size_t>(y) * map.width;
        for (int x = 0; x < map.width; ++x) {
            const float d = map.values[row + x];
            if (map.origins[row + x] != PixelOrigin::matched || !DisparityMap::known(d)) continue;
            const int seen = static_cast<int>(std::floor(static_cast<float>(x) - d + 0.5f));
            if (seen >= 0 && seen < map.width) nearest[row + seen] = std::max(nearest[row + seen], d);
        }
    });
    return nearest;
}

struct Box {
    float left = 1e9f, top = 1e9f, right = -1e9f, bottom = -1e9f;

    void add(float x, float y) {
        left = std::min(left, x);
        top = std::min(top, y);
        right = std::max(right, x);
        bottom = std::max(bottom, y);
    }
    double area() const { return right < left ? 0 : (right - left + 1.0) * (bottom - top + 1.0); }
};

// Finds the plane that a patch's matches support.
class PlaneFinder {
  public:
    PlaneFinder(const DisparityMap& map, double matched_share) : map_(map), matched_share_(matched_share) {}

    std::optional<DisparityPlane> plane_of(const Patch& patch) const {
        std::size_t matched = 0;
        Box box;
        for (const Run& run : patch.runs) {
            box.add(static_cast<float>(run.first), static_cast<float>(run.y));
            box.add(static_cast<float>(run.end - 1), static_cast<float>(run.y));
            for (int x = run.first; x < run.end; ++x) matched += is_matched(run.y, x);
        }
        if (matched < kLeastSamples ||
            static_cast<double>(matched) > matched_share_ * static_cast<double>(patch.pixels))
            return {};
        const std::vector<PlaneSample> samples = samples_of(patch, box);
        if (samples.size() < kLeastSamples) return {};
        const std::optional<PlaneFit> fit = fit_plane(samples, kHeldShare);
        if (!fit || fit->share < kOfSecond * fit->second_share) return {};
        Box spanned;
        for (const PlaneSample& s : samples)
            if (std::abs(fit->plane.at(s.x, s.y) - s.disparity) < kOnPlane_px) spanned.add(s.x, s.y);
        if (spanned.area() >= kSpannedShare * box.area()) return fit->plane;
        const double seen = seen_box(patch, fit->plane).area();
        if (seen < kSeenShare * box.area() || spanned.area() < kSpannedOfSeen * seen) return {};
        return fit->plane;
    }

  private:
    std::size_t pixel(int y, int x) const { return static_cast<std::size_t>(y) * map_.width + x; }
    bool is_matched(int y, int x) const {
        return map_.origins[pixel(y, x)] == PixelOrigin::matched &&
               DisparityMap::known(map_.values[pixel(y, x)]);
    }

    // Returns the box of what can have matches: not what lies beyond the right picture's left edge.
    static Box seen_box(const Patch& patch, const DisparityPlane& plane) {
        Box box;
        for (const Run& run : patch.runs)
            for (int x = run.first; x < run.end; ++x)
                if (plane.at(x, run.y) <= x) box.add(static_cast<float>(x), static_cast<float>(run.y));
        return box;
    }

    // Returns up to kCellSamples matches of each cell of a grid over the patch; each cell with matches has
    // the same weight, as a long rim would outweigh the few specks inside.
    std::vector<PlaneSample> samples_of(const Patch& patch, const Box& box) const {
        const double cell_px =
            std::max(kLeastCell_px, std::sqrt(static_cast<double>(patch.pixels)) / kCellsAcross);
        const auto cell_at = [&](float from, int to) {
            return static_cast<std::size_t>((static_cast<double>(to) - from) / cell_px);
        };
        const std::size_t columns = cell_at(box.left, static_cast<int>(box.right)) + 1,
                          rows = cell_at(box.top, static_cast<int>(box.bottom)) + 1;
        std::vector<int> matches(columns * rows), seen(columns * rows), taken(columns * rows);
        const auto for_matches = [&](const auto& take) {
            for (const Run& run : patch.runs) {
                const std::size_t row = cell_at(box.top, run.y) * columns;
                for (int x = run.first; x < run.end; ++x)
                    if (is_matched(run.y, x)) take(row + cell_at(box.left, x), x, run.y);
            }
        };
        for_matches([&](std::size_t cell, int, int) { ++matches[cell]; });
        const auto filled = static_cast<float>(
            std::count_if(matches.begin(), matches.end(), [](int count) { return count > 0; }));
        std::vector<PlaneSample> slots(matches.size() * kCellSamples), samples;
        for_matches([&](std::size_t cell, int x, int y) {
            const int count = matches[cell], most = std::min(count, kCellSamples), here = seen[cell]++;
            if (taken[cell] == most || here != (2 * taken[cell] + 1) * count / (2 * most)) return;
            slots[cell * kCellSamples + taken[cell]++] = {static_cast<float>(x), static_cast<float>(y),
                                                          map_.values[pixel(y, x)],
                                                          1.0f / (static_cast<float>(most) * filled)};
        });
        for (std::size_t cell = 0; cell < taken.size(); ++cell)
            samples.insert(samples.end(), &slots[cell * kCellSamples],
                           &slots[cell * kCellSamples] + taken[cell]);
        return samples;
    }

    const DisparityMap& map_;
    double matched_share_;
};

// Compares a patch's colours in both pictures.
class ColorCheck {
  public:
    ColorCheck(const DisparityMap& map, const cv::Mat& left, const cv::Mat& right, ThreadPool& pool)
        : map_(map), left_(left), right_(right), nearest_(nearest_matches(map, pool)) {}

    // Returns whether the colours fit along the plane as well as along the map, but for what something
    // matched hides.
    bool do_colors_fit(const Patch& patch, const DisparityPlane& plane) const {
        const std::size_t samples = std::min(patch.pixels, kColorSamples);
        std::size_t before = 0, next = 0;  // pixels of the runs before; samples taken
        int worse = 0;
        for (const Run& run : patch.runs) {
            const std::size_t end = before + static_cast<std::size_t>(run.end - run.first);
            for (; next < samples && next * patch.pixels / samples < end; ++next) {
                const int x = run.first + static_cast<int>(next * patch.pixels / samples - before);
                const float old = map_.values[pixel(run.y, x)], now = static_cast<float>(plane.at(x, run.y));
                if (!DisparityMap::known(old)) continue;
                const float by_map = difference(x, run.y, old), by_plane = difference(x, run.y, now);
                if (by_map < 0 || by_plane < 0) continue;
                const int seen = static_cast<int>(std::floor(static_cast<float>(x) - now + 0.5f));
                if (nearest_[pixel(run.y, std::clamp(seen, 0, map_.width - 1))] > now + kHidden_px) continue;
                worse += by_plane > by_map + kWorse;
                worse -= by_map > by_plane + kWorse;
            }
            before = end;
        }
        return worse <= kWorseShare * static_cast<double>(samples);
    }

  private:
    std::size_t pixel(int y, int x) const { return static_cast<std::size_t>(y) * map_.width + x; }

    // Returns the difference of a pixel's colour to that of its match, in levels of the most unlike channel;
    // negative beyond the right picture.
    float difference(int x, int y, float disparity) const {
        const float seen = static_cast<float>(x) - disparity, whole = std::floor(seen), part = seen - whole;
        const int at = static_cast<int>(whole), channels = left_.channels();
        if (at < 0 || at + 1 >= map_.width) return -1;
        const std::int16_t* const own = left_.ptr<std::int16_t>(y) + x * channels;
        const std::int16_t* const other = right_.ptr<std::int16_t>(y) + at * channels;
        float most = 0;
        for (int c = 0; c < channels; ++c) {
            const float level =
                static_cast<float>(other[c]) * (1 - part) + static_cast<float>(other[c + channels]) * part;
            most = std::max(most, std::abs(level - static_cast<float>(own[c])));
        }
        return most / kMeanOf;
    }

    const DisparityMap& map_;
    cv::Mat left_, right_;  // sums of colours
    std::vector<float> nearest_;
};

// A plane that rises towards a patch's end is not followed beyond what the map holds.
void put_on_plane(const Patch& patch, const DisparityPlane& plane, const KnownRange& range,
                  DisparityMap& map) {
    for (const Run& run : patch.runs)
        for (int x = run.first; x < run.end; ++x) {
            const std::size_t i = static_cast<std::size_t>(run.y) * map.width + x;
            const float d = std::clamp(static_cast<float>(plane.at(x, run.y)), range.least, range.largest);
            if (!DisparityMap::known(map.values[i])) continue;
            if (map.origins[i] != PixelOrigin::matched || std::abs(map.values[i] - d) > kOnPlane_px)
                map.values[i] = d;
        }
}

}  // namespace

DisparityMap with_planes_on_bare_patches(DisparityMap map, const StereoPair& pair, Pictures pictures,
                                         int threads) {
    const PatchLimits limits = pictures == Pictures::rectified ? kOfRectified : kOfPhotographs;
    constexpr int kLeastColumns = 3;
    const bool is_alike = pair.left.channels == pair.right.channels && pair.left.width == map.width;
    if (map.origins.empty() || !is_alike || map.width < kLeastColumns) return map;
    ThreadPool pool(threads);
    const cv::Mat left = colour_sums(pair.left, kMeanRadius_px, pool);
    const std::vector<Patch> patches = find_patches(left, limits.least_share, pool);
    std::vector<std::optional<DisparityPlane>> planes(patches.size());
    const auto for_patches = [&](const auto& take) {
        pool.parallel_for_chunks(patches.size(), [&](std::size_t first, std::size_t end) {
            for (std::size_t i = first; i < end; ++i) take(patches[i], planes[i]);
        });
    };
    const PlaneFinder finder(map, limits.matched_share);
    for_patches([&](const Patch& patch, auto& plane) { plane = finder.plane_of(patch); });
    if (std::none_of(planes.begin(), planes.end(), [](const auto& plane) { return plane.has_value(); }))
        return map;
    const ColorCheck check(map, left, colour_sums(pair.right, kMeanRadius_px, pool), pool);
    for_patches([&](const Patch& patch, auto& plane) {
        if (plane && !check.do_colors_fit(patch, *plane)) plane.reset();
    });
    const KnownRange range = known_range(map);
    for_patches([&](const Patch& patch, const auto& plane) {
        if (plane) put_on_plane(patch, *plane, range, map);
    });
    return map;
}

}  // namespace hexrelief::stages
