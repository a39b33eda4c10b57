#include "mesher/surface/pixels/pixel_surfaces.h"

#include <algorithm>

#include "mesher/surface/pixels/eight_flags.h"
#include "mesher/surface/pixels/pixel_surfaces_step.h"
#include "pipeline/base/simd.h"
#include "pipeline/base/thread_team.h"

namespace hexrelief::surface {
namespace {

// With all that it calls in one, so that loops vectorise at each width.
HEXRELIEF_VECTORS __attribute__((flatten)) void search(ThreadTeam& team, const step::PixelArrays& arrays,
                                                       const step::PixelRules& rules) {
    step::find_pixel_surfaces(team, arrays, rules);
}

}  // namespace

bool PixelSurfaces::may_meet(const Vec2f& a, const Vec2f& b) const {
    const auto pixel = [](float at, int size) { return std::clamp(static_cast<int>(at), 0, size - 1); };
    const int x0 = pixel(std::min(a.x, b.x) - step::kRounding_px, width),
              x1 = pixel(std::max(a.x, b.x) + step::kRounding_px, width),
              y0 = pixel(std::min(a.y, b.y) - step::kRounding_px, height),
              y1 = pixel(std::max(a.y, b.y) + step::kRounding_px, height);
    std::uint64_t any = 0;
    for (int x = x0; x <= x1; x += 8) {
        const std::uint8_t* row = flags.data() + static_cast<std::size_t>(y0) * width + x;
        std::uint64_t eight = 0;
        for (int y = y0; y <= y1; ++y, row += width) eight |= eight_flags(row);
        any |= eight & first_of_eight(x1 + 1 - x);
    }
    return (any & kCracksOfEight) != 0;
}

PixelSurfaces find_pixel_surfaces(const DisparityMap& map, float background_px, double cell_px,
                                  const SurfaceConfig& config, ThreadPool& pool) {
    const step::PixelRules rules = step::pixel_rules(config, background_px, cell_px);
    PixelSurfaces s{map.width, map.height, rules.discontinuity_px, {}, {}, step::tile_sum_count(map.width),
                    {}};
    const std::size_t pixels = map.values.size();
    s.disparity.resize(pixels);
    s.flags.resize(pixels + step::kMorePixelFlags);
    std::fill_n(s.flags.end() - step::kMorePixelFlags, step::kMorePixelFlags, std::uint8_t{0});
    s.tile_sums.resize(static_cast<std::size_t>(s.tile_columns) * step::tile_sum_count(s.height));
    // Memory that is not written is not taken, and little of this is.
    const std::size_t words = step::hole_words(s.width, s.height), entries = words * step::kHoleWord + 1;
    RawVector<unsigned> hole_words(words), numbers(words), roots(entries), areas(entries), pending(pixels);
    RawVector<float> found(pixels);
    step::PixelArrays::Counts counts{};
    const step::PixelArrays arrays{.width = s.width,
                                   .height = s.height,
                                   .map = map.values.data(),
                                   .disparity = s.disparity.data(),
                                   .flags = s.flags.data(),
                                   .tile_sums = s.tile_sums.data(),
                                   .words = hole_words.data(),
                                   .numbers = numbers.data(),
                                   .roots = roots.data(),
                                   .areas = areas.data(),
                                   .pending = pending.data(),
                                   .found = found.data(),
                                   .counts = &counts};
    ThreadTeam::run(pool, [&](ThreadTeam& team) { search(team, arrays, rules); });
    return s;
}

}  // namespace hexrelief::surface
