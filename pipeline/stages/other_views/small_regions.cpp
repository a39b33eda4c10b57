#include "pipeline/stages/other_views/small_regions.h"

#include <cmath>
#include <ranges>

#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {
namespace {

constexpr std::size_t kLeastRegion = 3;  // pixels that somebody would miss
// Highest step from row to row within a region that is not given away: floors at a grazing angle rise by a
// pixel a row and more, in steps of the three rows at which the right view's map is filled.
constexpr double kMergedStep_px = 3;
constexpr float kRamp_px = 0.9F;  // a pixel: less than a step between two surfaces

auto all_pixels(const DisparityMap& map) {
    return std::views::iota(std::uint32_t{0}, static_cast<std::uint32_t>(map.values.size()));
}

// Returns those of specks_of() that hold one of the seeds. down_px: in place of step_px from row to row.
template <class Seeds>
std::vector<std::uint32_t> specks_at(const DisparityMap& map, std::size_t least, double step_px,
                                     double down_px, const Seeds& seeds) {
    enum : char { kUnseen, kSeen, kOfLarge };
    std::vector<char> states(map.values.size(), kUnseen);
    std::vector<std::uint32_t> region, specks;
    for (const std::uint32_t seed : seeds) {
        if (!DisparityMap::known(map.values[seed]) || states[seed] != kUnseen) continue;
        if (seed % map.width > 0 && states[seed - 1] == kOfLarge &&
            std::abs(map.values[seed] - map.values[seed - 1]) <= step_px) {
            states[seed] = kOfLarge;
            continue;
        }
        region.assign(1, seed);
        states[seed] = kSeen;
        bool is_large = false;  // known as soon as there are enough pixels, or one of a large region
        for (std::size_t next = 0; next < region.size() && !is_large; ++next) {
            for_neighbours(map, region[next], [&](std::uint32_t i) {
                const std::uint32_t own = region[next];
                const double most_px = i + 1 == own || i == own + 1 ? step_px : down_px;
                if (states[i] == kSeen || !(std::abs(map.values[i] - map.values[own]) <= most_px)) return;
                is_large |= states[i] == kOfLarge;
                if (states[i] == kOfLarge) return;
                states[i] = kSeen;
                region.push_back(i);
            });
            is_large |= region.size() >= least;
        }
        if (is_large)
            for (const std::uint32_t i : region) states[i] = kOfLarge;
        else
            specks.insert(specks.end(), region.begin(), region.end());
    }
    return specks;
}

}  // namespace

std::vector<std::uint32_t> specks_of(const DisparityMap& map, std::size_t least, double step_px) {
    return specks_at(map, least, step_px, step_px, all_pixels(map));
}

void merge_specks(DisparityMap& map, std::size_t least) {
    struct Open {
        std::uint32_t pixel;
        float before, merged;
    };
    std::vector<Open> open;
    for (const std::uint32_t i : specks_at(map, least, kOneSurface_px, kMergedStep_px, all_pixels(map)))
        open.push_back({i, map.values[i], kUnknownDisparity});
    for (const Open& o : open) map.values[o.pixel] = kUnknownDisparity;
    for (std::size_t merged = open.size(); merged > 0;) {
        for (Open& o : open)
            for_neighbours(map, o.pixel,
                           [&](std::uint32_t i) { o.merged = std::min(o.merged, map.values[i]); });
        merged = std::erase_if(open, [&](const Open& o) {
            map.values[o.pixel] = o.merged;
            return DisparityMap::known(o.merged);
        });
    }
    for (const Open& o : open) map.values[o.pixel] = o.before;
    const auto alone = std::views::transform(open, &Open::pixel);
    for (const std::uint32_t i : specks_at(map, kLeastRegion, kOneSurface_px, kMergedStep_px, alone))
        map.values[i] = kUnknownDisparity;
}

std::vector<std::uint8_t> known_pixels(const DisparityMap& map) {
    std::vector<std::uint8_t> known(map.values.size());
    std::transform(map.values.begin(), map.values.end(), known.begin(), DisparityMap::known);
    return known;
}

void ramp_steps(DisparityMap& map, const std::vector<std::uint8_t>& is_shown, double most_px) {
    const auto width = static_cast<std::size_t>(map.width), count = map.values.size();
    const auto most = static_cast<float>(most_px);
    const auto fall_towards = [&](std::size_t pixel, std::size_t beside) {
        float& d = map.values[pixel];
        // Unknown pixels are infinitely far apart from all, or no number.
        const float step = d - map.values[beside];
        if (step > kRamp_px && step <= most) d = map.values[beside] + kRamp_px;
    };
    std::vector<std::size_t> hidden;  // all that may fall
    for (std::size_t i = 0; i < count; ++i)
        if (!is_shown[i] && DisparityMap::known(map.values[i])) hidden.push_back(i);
    for (const std::size_t i : hidden) {
        if (i >= width) fall_towards(i, i - width);
        if (i % width > 0) fall_towards(i, i - 1);
    }
    for (const std::size_t i : std::views::reverse(hidden)) {
        if (i + width < count) fall_towards(i, i + width);
        if ((i + 1) % width > 0) fall_towards(i, i + 1);
    }
}

std::vector<std::uint32_t> cracks_of(const DisparityMap& map, const Disparities& surface) {
    std::vector<std::uint32_t> specks = specks_of(map, kLeastSurface, kOneSurface_px);
    std::erase_if(specks, [&](std::uint32_t pixel) {
        bool goes_on = false;
        for_neighbours(map, pixel, [&](std::uint32_t i) {
            goes_on |=
                surface[i] != kNotCovered && std::abs(surface[i] - map.values[pixel]) <= kOneSurface_px;
        });
        return !goes_on;
    });
    return specks;
}

}  // namespace hexrelief::stages
