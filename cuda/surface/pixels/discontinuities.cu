#include "cuda/surface/pixels/discontinuities.h"

#include <cfloat>
#include <cmath>

#include "cuda/common/grid.cuh"
#include "cuda/common/warp_reduce.cuh"
#include "cuda/surface/pixels/regions.cuh"
#include "cuda/surface/pixels/speckles.cuh"
#include "mesher/surface/pixels/half_occlusion_step.h"

namespace hexrelief::cuda {
namespace {

// Writes the disparities without background and the words of pixels without foreground, and
// initialises the regions of the latter's short runs. least: the least large region; least_px: the
// least discontinuity, for between_half_occlusions().
__device__ void clean_pixels(const CooperativeGrid& grid, const SurfaceState& s, const PixelArrays& a,
                             unsigned least, float least_px) {
    constexpr int kRows = 8;  // loaded together: the number of loads in flight decides the time
    const int width = s.sizes.width, height = s.sizes.height;
    const unsigned lane = grid.lane(), groups = (height + kRows - 1) / kRows * a.words.per_row;
    for (unsigned group = grid.warp(); group < groups; group += grid.warps()) {
        const unsigned column = group % a.words.per_row;
        const int x = static_cast<int>(32 * column + lane),
                  y0 = static_cast<int>(group / a.words.per_row) * kRows;
        const unsigned first = static_cast<unsigned>(y0) * width + x;
        float own[kRows], halo[kRows];  // halo: two pixels beyond the word, in its first and last two lanes
        const int beyond = lane < 2 ? x - 2 : x + 2;
        const bool has_halo = (lane < 2 || lane >= 30) && beyond >= 0 && beyond < width;
        HEXRELIEF_UNROLL
        for (int k = 0; k < kRows; ++k) {
            const bool inside = y0 + k < height;
            own[k] = x < width && inside ? s.pixels.map[first + k * width] : 0.0f;
            halo[k] = has_halo && inside ? s.pixels.map[(y0 + k) * width + beyond] : 0.0f;
        }
        HEXRELIEF_UNROLL
        for (int k = 0; k < kRows; ++k) {
            if (y0 + k >= height) break;
            const float d = step::foreground(own[k], s.background_px);
            const float far = step::foreground(halo[k], s.background_px);
            const float first_beyond = __shfl_sync(~0u, far, lane == 0 ? 1 : 30);
            const float before = __shfl_up_sync(~0u, d, 1), before2 = __shfl_up_sync(~0u, d, 2);
            const float after = __shfl_down_sync(~0u, d, 1), after2 = __shfl_down_sync(~0u, d, 2);
            const float right = lane == 31 ? first_beyond : after;
            const float settled =
                step::between_half_occlusions(lane < 2 ? far : before2, lane == 0 ? first_beyond : before, d,
                                              right, lane >= 30 ? far : after2, least_px);
            if (x < width) s.pixels.disparity[first + k * width] = settled;
            const bool is_empty = x < width && !(d > 0);
            const unsigned empty = __ballot_sync(~0u, is_empty), word = (y0 + k) * a.words.per_row + column;
            if (lane == 31) {
                const unsigned next_is_empty = x + 1 < width && !(right > 0);
                a.empty[word] = empty;
                a.right[word] = empty & (empty >> 1 | next_is_empty << 31);
            }
            if (empty == 0) continue;
            const unsigned runs = empty & (empty >> 1);
            if ((empty & run_starts(runs) & ~long_runs(runs, least)) >> lane & 1)
                Regions{a.regions}.begin(first + k * width + 1);
        }
    }
    grid.wait();
}

// The memory that the lanes of a warp share while they find a patch's discontinuities.
struct PatchScratch {
    unsigned discontinuities[2 * kPatchRows];  // right and down, one word for each row
    std::uint8_t steps[64 * kPatchRows];
};

__device__ PatchScratch& own_scratch() {
    __shared__ PatchScratch scratch[kGridWarps];
    return scratch[threadIdx.x / 32];
}

// A patch as the lanes of a warp hold it, a column each.
struct PatchPixels {
    float disparity[kPatchRows + 1];  // px, 0 outside the map
    float beyond[kPatchRows];         // in lane 31: the pixel to the right of the patch
    unsigned absorbed[kPatchRows];    // words of pixels
};

struct PatchPosition {
    int x0, x, y0;         // px; x belongs to the lane
    unsigned row, column;  // of the patch
    __device__ PatchPosition(const PixelArrays& a, unsigned patch, unsigned lane)
        : row(patch / a.words.per_row), column(patch % a.words.per_row) {
        x0 = static_cast<int>(32 * column);
        x = x0 + static_cast<int>(lane);
        y0 = static_cast<int>(row * kPatchRows);
    }
};

__device__ PatchPixels load_patch(const SurfaceState& s, const PixelArrays& a, unsigned patch,
                                  unsigned lane) {
    const PatchPosition at(a, patch, lane);
    const int width = s.sizes.width, height = s.sizes.height;
    const unsigned first = static_cast<unsigned>(at.y0) * width + at.x;
    PatchPixels pixels;
    HEXRELIEF_UNROLL
    for (int k = 0; k <= static_cast<int>(kPatchRows); ++k)
        pixels.disparity[k] =
            at.x < width && at.y0 + k < height ? s.pixels.disparity[first + k * width] : 0.0f;
    HEXRELIEF_UNROLL
    for (int k = 0; k < static_cast<int>(kPatchRows); ++k) {
        const bool inside = at.y0 + k < height;
        pixels.beyond[k] =
            lane == 31 && at.x + 1 < width && inside ? s.pixels.disparity[first + k * width + 1] : 0.0f;
        pixels.absorbed[k] = inside ? a.absorbed[(at.y0 + k) * a.words.per_row + at.column] : 0;
    }
    return pixels;
}

// Returns the steps of the lane's column of a patch: per row a bit for the right and one for the lower step.
__device__ unsigned find_steps(const SurfaceSizes& sizes, const PatchPixels& pixels, const PatchPosition& at,
                               unsigned lane, float least_px) {
    const float* const d = pixels.disparity;
    unsigned steps = 0;
    HEXRELIEF_UNROLL
    for (int k = 0; k < static_cast<int>(kPatchRows); ++k) {
        const float beside = __shfl_down_sync(~0u, d[k], 1);
        const float right = at.x + 1 >= sizes.width ? d[k] : lane == 31 ? pixels.beyond[k] : beside;
        const float below = at.y0 + k + 1 < sizes.height ? d[k + 1] : d[k];
        steps |= static_cast<unsigned>(step::steps_at(d[k], right, below, least_px)) << (2 * k);
    }
    return steps;
}

// Finds which steps of the patch are discontinuities, right and down of each row, by the whole
// warp.
__device__ void judge_steps(const SurfaceState& s, const PatchPosition& at, unsigned steps, unsigned lane,
                            float least_px, unsigned discontinuities[2 * kPatchRows]) {
    const int width = s.sizes.width, height = s.sizes.height;
    PatchScratch& scratch = own_scratch();
    unsigned count = 0;
    // Steps are few: the warp lists them, so that each lane gets one to test.
    HEXRELIEF_UNROLL
    for (unsigned k = 0; k < 2 * kPatchRows; ++k) {
        const unsigned word = __ballot_sync(~0u, steps >> k & 1);
        if (lane == k) scratch.discontinuities[k] = word;
        if (steps >> k & 1)
            scratch.steps[count + count_before_lane(word)] = static_cast<std::uint8_t>(32 * k + lane);
        count += __popc(word);
    }
    __syncwarp();
    for (unsigned k = lane; k < count; k += 32) {
        const unsigned own = scratch.steps[k], bit = own % 32;
        const step::Crack crack{at.x0 + static_cast<int>(bit), at.y0 + static_cast<int>(own / 64),
                                static_cast<int>(own / 32 % 2)};
        const unsigned i = static_cast<unsigned>(crack.y) * width + crack.x;
        if (!step::is_discontinuity_of_step(s.pixels.disparity + i, crack, width, height, least_px))
            atomicAnd(&scratch.discontinuities[own / 32], ~(1u << bit));
    }
    __syncwarp();
    HEXRELIEF_UNROLL
    for (unsigned k = 0; k < 2 * kPatchRows; ++k) discontinuities[k] = scratch.discontinuities[k];
    __syncwarp();
}

// least_px: the height from which on steps can be discontinuities; begins_regions: true the first time, when
// the regions of pixels have to be initialised as well.
struct Search {
    float least_px;
    bool begins_regions;
};

// Finds the discontinuities of a patch's pixels and writes all data that depend on them.
__device__ void find_discontinuities(const SurfaceState& s, const PixelArrays& a, const PatchPixels& pixels,
                                     unsigned patch, unsigned lane, const Search& search) {
    constexpr int kRows = static_cast<int>(kPatchRows);
    const int width = s.sizes.width, height = s.sizes.height;
    const PatchPosition at(a, patch, lane);
    const unsigned first_pixel = static_cast<unsigned>(at.y0) * width + at.x;
    const unsigned steps = find_steps(s.sizes, pixels, at, lane, search.least_px);
    unsigned discontinuities[2 * kPatchRows] = {};
    if (__any_sync(~0u, steps != 0)) judge_steps(s, at, steps, lane, search.least_px, discontinuities);

    const unsigned left = static_cast<unsigned>(width - at.x0), within = left < 32 ? (1u << left) - 1 : ~0u,
                   before_last = left > 32 ? ~0u : within >> 1;
    unsigned crowded = 0;  // number of pixels with discontinuities
    float nearest = 0, farthest = FLT_MAX;
    HEXRELIEF_UNROLL
    for (int k = 0; k < kRows; ++k) {
        const int y = at.y0 + k;
        if (y >= height) break;
        const float d = pixels.disparity[k];
        nearest = step::max_of(nearest, d);
        if (d > 0) farthest = step::min_of(farthest, d);
        const unsigned right = discontinuities[2 * k], down = discontinuities[2 * k + 1];
        crowded += (right | down) >> lane & 1;
        if (at.x < width)
            s.pixels.flags[first_pixel + k * width] =
                static_cast<std::uint8_t>((right >> lane & 1) * step::kDiscontinuityRight |
                                          (down >> lane & 1) * step::kDiscontinuityDown |
                                          (~pixels.absorbed[k] >> lane & 1) * step::kTrusted);
        if (!search.begins_regions) continue;
        const unsigned open = before_last & ~right;
        if (lane == 0) {
            a.right[y * a.words.per_row + at.column] = open;
            a.down[y * a.words.per_row + at.column] = y + 1 < height ? within & ~down : 0;
        }
        if ((within & run_starts(open) & ~long_runs(open, step::kLeastRegion_px)) >> lane & 1)
            Regions{a.regions}.begin(first_pixel + k * width + 1);
    }
    if (search.begins_regions && lane == 0) a.is_stale[patch] = 0;
    crowded += __shfl_xor_sync(~0u, crowded, 1);
    crowded += __shfl_xor_sync(~0u, crowded, 2);
    static_assert(step::kTile_px == 4 && kPatchRows == 4);
    if (lane % 4 == 0 && at.x < width)
        s.pixels.tile_sums[(at.row + 1) * step::tile_sum_count(width) + at.x / step::kTile_px + 1] = crowded;
    nearest = most_of_lanes(nearest);
    farthest = least_of_lanes(farthest);
    if (lane == 0) {
        a.nearest[patch] = nearest;
        a.farthest[patch] = farthest;
    }
}

// patches null: the list is 0 .. count - 1.
struct PatchList {
    const unsigned* patches;
    unsigned count;
};

// Does the same for the patches of a list, each loaded while the preceding one is worked on; then a barrier.
__device__ void find_discontinuities_of_patches(const CooperativeGrid& grid, const SurfaceState& s,
                                                const PixelArrays& a, const PatchList& list,
                                                const Search& search) {
    const unsigned lane = grid.lane(), warps = grid.warps(), count = list.count;
    const auto patch = [&](unsigned k) { return list.patches ? list.patches[k] : k; };
    unsigned k = grid.warp();
    if (k < count) {
        unsigned own = patch(k);
        PatchPixels pixels = load_patch(s, a, own, lane);
        HEXRELIEF_ROLLED
        for (bool more = true; more;) {
            k += warps;
            more = k < count;
            const unsigned next = more ? patch(k) : own;
            PatchPixels coming = pixels;
            if (more) coming = load_patch(s, a, next, lane);
            find_discontinuities(s, a, pixels, own, lane, search);
            own = next;
            pixels = coming;
        }
    }
    grid.wait();
}

// Replaces `count` numbers, `stride` apart, by their prefix sums; by one warp.
__device__ void sum_line(std::uint32_t* numbers, unsigned stride, unsigned count, unsigned lane) {
    constexpr unsigned kAtOnce = 4;
    unsigned before = 0;
    for (unsigned start = 0; start < count; start += 32 * kAtOnce) {
        unsigned own[kAtOnce];
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kAtOnce; ++k) {
            const unsigned i = start + 32 * k + lane;
            own[k] = i < count ? numbers[std::size_t{i} * stride] : 0;
        }
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kAtOnce; ++k) {
            own[k] = before + sum_up_to_lane(own[k]);
            before = __shfl_sync(~0u, own[k], 31);
            const unsigned i = start + 32 * k + lane;
            if (i < count) numbers[std::size_t{i} * stride] = own[k];
        }
    }
}

// Finds the totals' nearest and farthest disparity.
__device__ void find_disparity_range(const CooperativeGrid& grid, const SurfaceState& s,
                                     const PixelArrays& a) {
    float nearest = 0, farthest = FLT_MAX;
    for (unsigned patch = grid.thread(); patch < a.patches; patch += grid.threads()) {
        nearest = step::max_of(nearest, a.nearest[patch]);
        farthest = step::min_of(farthest, a.farthest[patch]);
    }
    nearest = most_of_lanes(nearest);
    farthest = least_of_lanes(farthest);
    if (grid.lane() == 0 && nearest > 0) {
        atomicMax(reinterpret_cast<unsigned*>(&s.totals->nearest_px), __float_as_uint(nearest));
        atomicMin(reinterpret_cast<unsigned*>(&s.totals->farthest_px), __float_as_uint(farthest));
    }
}

// Turns the tiles' counts into sums over all tiles above and to the left.
__device__ void sum_tiles(const CooperativeGrid& grid, const SurfaceState& s) {
    const unsigned columns = step::tile_sum_count(s.sizes.width), rows = step::tile_sum_count(s.sizes.height);
    grid.each_by_warp(rows, [&](unsigned row, unsigned lane) {
        std::uint32_t* const sums = s.pixels.tile_sums + std::size_t{row} * columns;
        if (row == 0)
            for (unsigned i = lane; i < columns; i += 32) sums[i] = 0;
        else
            sum_line(sums + 1, 1, columns - 1, lane);
        if (lane == 0) sums[0] = 0;
    });
    grid.each_by_warp(columns - 1, [&](unsigned column, unsigned lane) {
        sum_line(s.pixels.tile_sums + columns + column + 1, columns, rows - 1, lane);
    });
}

__device__ void find_pixel_surfaces(CooperativeGrid& grid, const SurfaceState& s, const PixelArrays& a) {
    PixelCounts& counts = *a.counts;
    if (grid.thread() == 0) {
        counts = {};
        Regions{a.regions}.begin(0);
        *s.totals = {};
        s.totals->nearest_px = s.nearest_px;
        s.totals->farthest_px = s.farthest_px;
    }
    grid.wait();

    const unsigned least_hole = static_cast<unsigned>(step::clamp_to(std::ceil(s.cell_px), 1.0, 1e9));
    const float discontinuity_px = static_cast<float>(s.config.least_discontinuity_px) > 0
                                       ? static_cast<float>(s.config.least_discontinuity_px)
                                       : step::kDiscontinuity_px;
    const float least_px = s.bridges() ? HUGE_VALF : discontinuity_px;
    clean_pixels(grid, s, a, least_hole, least_px);
    if (grid.thread() == 0) s.totals->discontinuity_px = discontinuity_px;

    // Holes come first, because they may tear surfaces into speckles, which then are whole again. One loop
    // does both, so that the second round finds the code in the instruction cache.
    HEXRELIEF_ROLLED
    for (int round = 0; round < 2; ++round) {
        const bool holes = round == 0;
        const unsigned least = holes ? least_hole : step::kLeastRegion_px;
        const auto members = [&](unsigned word) {
            const unsigned left = a.words.width - 32 * (word % a.words.per_row);
            return holes ? a.empty[word] : left < 32 ? (1u << left) - 1 : ~0u;
        };
        const auto right = [&](unsigned word) { return a.right[word]; };
        const auto down = [&](unsigned word) {
            return holes ? a.empty[word] & a.empty[word + a.words.per_row] : a.down[word];
        };
        join_regions(grid, Regions{a.regions}, least, right, down);
        measure_regions(grid, Regions{a.regions}, least, members, right);
        PixelCounts::Speckles& found = holes ? counts.holes : counts.speckles;
        find_speckles(grid, Regions{a.regions}, least, members, right, [&](unsigned word, unsigned speckles) {
            a.speckles[word] = speckles;
            a.deep[word] = 0;
            a.absorbed[word] = holes ? speckles : a.absorbed[word] | speckles;
            if (!speckles) return;
            atomicAdd(&found.pixels, __popc(speckles));
            a.speckle_words[atomicAdd(&found.words, 1)] = word;
        });
        absorb_speckles(grid, s, a, &found, holes ? nullptr : &counts.patches,
                        holes ? step::Around::hole : step::Around::speckle);
        find_discontinuities_of_patches(
            grid, s, a, holes ? PatchList{nullptr, a.patches} : PatchList{a.stale_patches, counts.patches},
            {least_px, holes});
    }
    find_disparity_range(grid, s, a);
    sum_tiles(grid, s);
}

__global__ void __launch_bounds__(kGridThreads, 1)
    find_pixel_surfaces_kernel(const __grid_constant__ SurfaceState s,
                               const __grid_constant__ PixelArrays a) {
    CooperativeGrid grid(s.board);
    find_pixel_surfaces(grid, s, a);
}

}  // namespace

void find_pixel_surfaces(const Launch& launch, const SurfaceState& s, const PixelArrays& a) {
    launch_cooperative(launch, find_pixel_surfaces_kernel, 0, "finding discontinuities", s, a);
}

}  // namespace hexrelief::cuda
