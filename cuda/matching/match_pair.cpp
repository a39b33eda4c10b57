#include "cuda/matching/match_pair.h"

#include <algorithm>
#include <future>
#include <string>
#include <vector>

#include "cuda/matching/refine/refine.h"
#include "cuda/matching/refine/voters.h"
#include "cuda/matching/sgm/match_views.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::cuda {

// The pair at one of its sizes, and its matches.
struct PairLevel {
    matching::DisparityRange range;
    int width, height;
    matching::RasterView<std::int16_t> left, right;  // winners, with a border of kUnknown16
    DeviceColors colors;
    PairPixels pixels;
    PairArrays pair;
};

// The properties of a call that its launches depend on, that is, all except the pictures' pixels.
struct PlanKey {
    int width, height, left_channels, right_channels;
    matching::MatchingConfig config;

    bool operator==(const PlanKey&) const = default;
};

namespace {

constexpr int kLongestSide_px = 32767;

void check_limits(const StereoPair& pair, const matching::MatchingConfig& config) {
    if (config.range.count > kMostDisparities)
        throw Error(ErrorKind::device, "backend cuda: " + std::to_string(config.range.count) +
                                           " disparities; at most " + std::to_string(kMostDisparities) +
                                           " can be searched; use --backend cpu");
    if (std::max(pair.left.width, pair.left.height) > kLongestSide_px)
        throw Error(ErrorKind::device,
                    "backend cuda: the pictures' sides may have 32767 px; use --backend cpu");
}

PairLevel take_level(Arena& arena, int width, int height, const matching::DisparityRange& range,
                     bool in_color) {
    const auto map = [&] { return take_bordered_raster<std::int16_t>(arena, width, height); };
    const auto colors = [&] { return take_plain_raster<std::uint32_t>(arena, width, height); };
    return {range, width, height, map(), map(), {colors(), colors(), in_color}, {}, {}};
}

// Takes the memory of all levels, finest first. Like match() of pipeline/matching it goes down to the size at
// which the whole range is searched, and at least to half size, whose matches fill holes.
std::vector<PairLevel> take_levels(Arena& arena, const StereoPair& pair,
                                   const matching::DisparityRange& range) {
    const bool in_color = pair.left.channels == pair.right.channels && pair.left.channels > 1;
    std::vector<PairLevel> levels = {take_level(arena, pair.left.width, pair.left.height, range, in_color)};
    while (levels.size() < 2 || !matching::is_searched_wholly(levels.back().range)) {
        const PairLevel& last = levels.back();
        levels.push_back(take_level(arena, step::half_size(last.width), step::half_size(last.height),
                                    matching::at_half_size(last.range), in_color));
    }
    return levels;
}

void take_pixels(Arena& arena, const StereoPair& pair, PairLevel& level) {
    const Image* const images[] = {&pair.left, &pair.right};
    for (int i = 0; i < 2; ++i) {
        level.pixels.pixels[i] = arena.take<std::uint8_t>(images[i]->pixels.size());
        level.pixels.channels[i] = images[i]->channels;
    }
}

void upload(Workspace& work, const StereoPair& pair, const PairPixels& to) {
    const Image* const images[] = {&pair.left, &pair.right};
    for (int i = 0; i < 2; ++i)
        work.staging.upload(work.stream, const_cast<std::uint8_t*>(to.pixels[i]), images[i]->pixels.data(),
                            images[i]->pixels.size());
}

// Makes the pictures of all levels from those of the first one.
void halve_pictures(cudaStream_t stream, Arena& arena, std::vector<PairLevel>& levels) {
    for (std::size_t first = 0; first + 1 < levels.size(); first += kMostHalvings) {
        std::vector<HalvedPixels> halved;
        const PairLevel& from = levels[first];
        for (std::size_t i = first + 1; i < levels.size() && i <= first + kMostHalvings; ++i) {
            PairLevel& level = levels[i];
            halved.emplace_back();
            for (int k = 0; k < 2; ++k) {
                const int channels = level.pixels.channels[k] = from.pixels.channels[k];
                level.pixels.pixels[k] = halved.back().pixels[k] =
                    arena.take<std::uint8_t>(static_cast<std::size_t>(level.width) * level.height * channels);
            }
        }
        halve(stream, from.pixels, from.width, from.height, halved);
    }
}

matching::ConsistencyConfig consistency_of(matching::ConsistencyConfig config, const PairLevel& level) {
    config.min_px = level.range.min_px;
    return config;
}

CheckArrays take_check_arrays(Arena& arena, const PairLevel& level,
                              const matching::RasterView<std::int16_t>& checked) {
    const auto map = [&] { return take_bordered_raster<std::int16_t>(arena, level.width, level.height); };
    const std::size_t pixels = static_cast<std::size_t>(level.width) * level.height;
    return {level.left,
            level.right,
            map(),
            map(),
            {arena.take<std::uint32_t>(pixels), arena.take<std::uint32_t>(pixels)},
            checked};
}

void fill_borders_of(cudaStream_t stream, const std::vector<PairLevel>& levels, const CheckArrays& check) {
    std::vector<Border> borders;
    for (const matching::RasterView<std::int16_t>& map :
         {check.left_medians, check.right_medians, check.checked})
        borders.push_back({map, kUnknownBytes});
    for (const PairLevel& level : levels)
        for (const matching::RasterView<std::int16_t>& map : {level.left, level.right})
            borders.push_back({map, kUnknownBytes});
    fill_borders(stream, borders);
}

// Finds the winners of all levels, of both views if these are compared, and checks those of half size. Small
// levels leave most of the device idle: therefore the side stream first makes the pictures, prepares the next
// level while one is matched, and checks half size beside the last one.
void match_levels(Workspace& work, const matching::MatchingConfig& config, std::vector<PairLevel>& levels,
                  const CheckArrays& check_half, const matching::RasterView<std::uint32_t>& hole_colors) {
    const cudaStream_t side = work.side.get();
    const auto prepare = [&](PairLevel& level) {
        prepare_pair(side, level.pixels, level.pair);
        work.side.mark();
    };
    halve_pictures(side, work.arena, levels);
    prepare(levels.back());
    for (std::size_t i = levels.size(); i-- > 0;) {
        const PairLevel& level = levels[i];
        work.side.let_wait_for_mark(work.stream);
        if (i > 0) prepare(levels[i - 1]);
        if (i == 1) blur_colors(side, reading(levels[0].colors.left), hole_colors);
        match_views(work, level.pair, {level.range, config.penalties},
                    i + 1 < levels.size() ? levels[i + 1].left : matching::RasterView<std::int16_t>{},
                    {level.left, i <= 1 ? level.right : matching::RasterView<std::int16_t>{}});
        if (i != 1) continue;
        work.side.begin_after(work.stream);
        check_views(side, check_half, consistency_of(matching::at_half_size(config.consistency), level));
    }
    work.side.mark();
    work.side.let_wait_for_mark(work.stream);
}

PlanKey key_of(const StereoPair& pair, const matching::MatchingConfig& config) {
    return {pair.left.width, pair.left.height, pair.left.channels, pair.right.channels, config};
}

}  // namespace

// A call's arrays and launches. The next call uses them again if it has the same key.
struct DeviceMatcher::Plan {
    PlanKey key;
    std::vector<PairLevel> levels;
    DeviceHalfSizeMatches half_size;
    CheckArrays check_half;
    matching::RasterView<std::uint32_t> hole_colors;
    FrameArrays frame;
    Arena::Mark levels_taken, taken;
    RefineArrays refined;
    Recording until_filled, to_the_end;

    Plan(Arena& arena, const StereoPair& pair, const matching::MatchingConfig& config)
        : key(key_of(pair, config)), levels(take_levels(arena, pair, config.range)) {
        const PairLevel& half = levels[1];
        half_size = {take_bordered_raster<std::int16_t>(arena, half.width, half.height), half.range.min_px};
        hole_colors = take_plain_raster<std::uint32_t>(arena, levels[0].width, levels[0].height);
        frame = take_frame_arrays(arena, matching::cell_grid(levels[0].width, levels[0].height));
        levels_taken = arena.mark();
        for (PairLevel& level : levels) level.pair = take_pair_arrays(arena, level.colors);
        check_half = take_check_arrays(arena, half, half_size.left);
        take_pixels(arena, pair, levels[0]);
        taken = arena.mark();
    }
    RefineInput refine_input() const {
        return {levels[0].colors, reading(hole_colors), half_size,
                consistency_of(key.config.consistency, levels[0])};
    }
};

DeviceMatcher::DeviceMatcher() = default;
DeviceMatcher::~DeviceMatcher() = default;

matching::MatchedMap DeviceMatcher::match_pair(const StereoPair& pair,
                                               const matching::MatchingConfig& config) {
    check_limits(pair, config);
    const cudaStream_t stream = work.stream;
    Arena& arena = work.arena;
    // waits for work that a failed call may have left
    work.side.mark();
    work.side.let_wait_for_mark(stream);
    std::unique_ptr<Plan> plan = std::move(plan_);
    if (!plan || plan->key != key_of(pair, config)) {
        plan.reset();
        arena.reset();
        plan = std::make_unique<Plan>(arena, pair, config);
    }
    // Runs on the host beside the launches, and while the device matches.
    std::future<matching::FrameSegments> frame_segments = std::async(std::launch::async, [&] {
        return matching::find_frame_segments(pair.left, config.range.min_px + config.range.count);
    });
    PairLevel& full = plan->levels[0];
    const RefineInput refine_input = plan->refine_input();
    upload(work, pair, full.pixels);
    plan->until_filled.run(stream, [&] {
        arena.release(plan->taken);
        work.side.begin_after(stream);
        fill_borders_of(stream, plan->levels, plan->check_half);
        match_levels(work, config, plan->levels, plan->check_half, plan->hole_colors);
        arena.release(plan->levels_taken);
        plan->refined = take_refine_arrays(arena, full.left, full.right, plan->frame);
        fill(work, plan->refined, refine_input);
    });
    const RefineArrays& refined = plan->refined;
    raise_frame_segments(work, frame_segments.get(), refined);
    plan->to_the_end.run(stream, [&] { smooth(work, refined, refine_input); });

    const int width = full.width, height = full.height;
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    matching::MatchedMap map{width, height, {}, {}};
    map.disparities.resize(pixels);
    map.is_matched.resize(pixels);
    work.staging.download_all(stream,
                              {{map.disparities.data(), refined.result.origin, pixels * sizeof(std::int16_t)},
                               {map.is_matched.data(), refined.trusted.matched.origin, pixels}});
    plan_ = std::move(plan);
    return map;
}

}  // namespace hexrelief::cuda
