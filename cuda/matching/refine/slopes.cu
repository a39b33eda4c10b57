#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/record_access.cuh"
#include "cuda/matching/refine/slopes.h"
#include "pipeline/matching/refine/slope_step.h"
#include "pipeline/matching/refine/smooth_step.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::cuda {
namespace {

// Lines along x and y are fitted together: each word holds two numbers, the one of x in the lower half.
constexpr std::uint32_t kUnknownBits = step::in_halves<std::uint32_t>(step::kUnknownBit);

// Sums up the samples on one side of the pixel. along_x, along_y: entries to a neighbour on that side.
__device__ step::SideSums<std::uint32_t> side_sums(const std::int16_t* pixel, std::uint32_t own, int along_x,
                                                   std::ptrdiff_t along_y) {
    step::SideSums<std::uint32_t> sums{kBoth};
    std::uint32_t before = own;
#pragma unroll
    for (unsigned k = 1; k <= step::kSamples; ++k) {
        const std::uint32_t here =
            __byte_perm(pixel[static_cast<int>(k) * along_x], pixel[k * along_y], 0x5410) | kUnknownBits;
        sums.add(k, here, before, own);
        before = here & ~kUnknownBits;
    }
    return sums;
}

// Tables by the numbers of samples before and behind a pixel, and by the number of pixels on its surface.
struct SlopeTables {
    step::LinePlaces places[step::kSamples + 1][step::kSamples + 1];
    float shares[step::kMostSlopes + 1];
};
constexpr SlopeTables slope_tables() {
    SlopeTables tables{};
    for (int before = 0; before <= step::kSamples; ++before)
        for (int behind = 0; behind <= step::kSamples; ++behind)
            tables.places[before][behind] = step::LinePlaces(before, behind);
    for (int count = 0; count <= step::kMostSlopes; ++count) tables.shares[count] = step::share_of(count);
    return tables;
}
__device__ constexpr SlopeTables kTables = slope_tables();

// Returns the slope from the sums in the lower halves of the words.
__device__ int slope_along(std::uint32_t v_before, std::uint32_t tv_before, std::uint32_t v_behind,
                           std::uint32_t tv_behind) {
    const step::SideSum before(v_before & 0xffffu), behind(v_behind & 0xffffu), t_before(tv_before & 0xffffu),
        t_behind(tv_behind & 0xffffu);
    return step::line_slope(kTables.places[before.count][behind.count], before.sum + behind.sum,
                            t_behind.sum - t_before.sum);
}

// Both slopes are packed, each increased by kSteepest, with a 1 above them, so that the sum of 15 words holds
// the three sums; 0 if the disparity is unknown.
constexpr int kSlopeBits = 14;
constexpr std::uint32_t kSlopeMask = (1u << kSlopeBits) - 1;
static_assert(15 * 2 * step::kSteepest < 1 << kSlopeBits);

// True if one of the block's pixels, or of those within a block's height around it, may have changed. All
// lanes of a warp call it.
__device__ bool may_change(const matching::RasterView<const std::uint8_t>& changed_blocks) {
    static_assert(step::kSamples + step::kSlopeRadius * step::kNearSlopes_px <= 8);
    if (!changed_blocks.origin) return true;
    const int lane = static_cast<int>(threadIdx.x), x = static_cast<int>(blockIdx.x) + lane % 3 - 1,
              y = static_cast<int>(blockIdx.y) + lane / 3 - 1;
    return __any_sync(~0u, lane < 9 && x >= 0 && x < changed_blocks.width && y >= 0 &&
                               y < changed_blocks.height && changed_blocks.at(x, y));
}

__global__ void fit_slopes(RecordInput in, SlopeArrays out) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    const matching::DisparityView& map = in.map;
    if (at.y >= map.height || !may_change(in.changed_blocks)) return;  // a warp returns together
    const std::int16_t* const pixel = &map.at(at.x, at.y);
    const bool inside = at.x < map.width;
    bool discontinuous = false;
    FittedPixel fitted{0, *pixel};
    if (inside && *pixel >= 0) {
        const std::uint32_t own = static_cast<std::uint32_t>(*pixel) * kBoth;
        const auto before = side_sums(pixel, own, -1, -static_cast<std::ptrdiff_t>(map.stride)),
                   behind = side_sums(pixel, own, 1, map.stride);
        const int x = slope_along(before.v, before.tv, behind.v, behind.tv),
                  y = slope_along(before.v >> 16, before.tv >> 16, behind.v >> 16, behind.tv >> 16);
        fitted.slopes = static_cast<std::uint32_t>(x + step::kSteepest) |
                        static_cast<std::uint32_t>(y + step::kSteepest) << kSlopeBits |
                        1u << (2 * kSlopeBits);
        if (out.discontinuous.origin) discontinuous = step::beside_discontinuity(pixel, map.stride);
    }
    if (inside) out.fitted.at(at.x, at.y) = fitted;
    if (!out.discontinuous.origin) return;
    const std::uint32_t bits = __ballot_sync(~0u, discontinuous);
    if (threadIdx.x == 0) out.discontinuous.at(static_cast<int>(blockIdx.x), at.y) = bits;
}

__device__ bool is_known_beside_unknown(const matching::DisparityView& map, int x, int y) {
    bool unknown = false;
#pragma unroll
    for (int j = -1; j <= 1; ++j)
#pragma unroll
        for (int i = -1; i <= 1; ++i) unknown |= map.at(x + i, y + j) < 0;
    return unknown && map.at(x, y) >= 0;
}

__device__ void write_mean(const RecordInput& in, int2 at, int disparity, std::uint32_t slopes,
                           PixelRecord* to) {
    const bool first_round = in.voter_weights.origin != nullptr;
    const std::uint8_t weight = first_round ? in.voter_weights.at(at.x, at.y) : step::kMatchedWeight;
    const std::uint32_t no_color = disparity < 0 ? kNoColor : 0;
    write_record({static_cast<std::int16_t>(disparity), weight, slopes, in.colors.at(at.x, at.y) | no_color,
                  (first_round ? in.hole_colors.at(at.x, at.y) : 0) | no_color},
                 to);
}
__device__ void write_mean(const RecordInput& in, int2 at, int disparity, std::uint32_t slopes,
                           PlaneRecord* to) {
    const std::uint32_t color = in.colors.at(at.x, at.y);
    write_record(
        {disparity, slopes, disparity < 0 ? step::PlaneColor::kUnknown : step::PlaneColor::packed(color), 0},
        to);
}

template <typename Record>
__global__ void average_slopes(RecordInput in, matching::RasterView<const FittedPixel> fitted,
                               matching::RasterView<Record> out) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (!may_change(in.changed_blocks) || at.x >= in.map.width || at.y >= in.map.height) return;
    if (in.which == RecordsOf::beside_unknown && !is_known_beside_unknown(in.map, at.x, at.y)) return;
    const int own = fitted.at(at.x, at.y).disparity;
    std::uint32_t sums = 0;
#pragma unroll
    for (int j = -step::kSlopeRadius; j <= step::kSlopeRadius; ++j) {
        const FittedPixel* const row = fitted.row(at.y + j * in.slope_stride_px) + at.x;
#pragma unroll
        for (int i = -step::kSlopeRadius; i <= step::kSlopeRadius; ++i) {  // an unknown pixel adds nothing
            if (!step::is_dark(i, j)) continue;
            const FittedPixel& other = row[i * in.slope_stride_px];
            if (step::is_same_surface<int>(other.disparity, own)) sums += other.slopes;
        }
    }
    const int count = static_cast<int>(sums >> (2 * kSlopeBits)), more = count * step::kSteepest;
    const int sum_x = static_cast<int>(sums & kSlopeMask) - more,
              sum_y = static_cast<int>(sums >> kSlopeBits & kSlopeMask) - more;
    const float share = kTables.shares[count];
    write_mean(in, at, own,
               packed_slopes(step::rounded_slope(sum_x, share), step::rounded_slope(sum_y, share)),
               &out.at(at.x, at.y));
}

}  // namespace

template <typename Record>
void find_slopes(cudaStream_t stream, const RecordInput& input, const SlopeArrays& arrays,
                 const matching::RasterView<Record>& records) {
    const Blocks blocks = pixel_blocks(input.map.width, input.map.height);
    launch("fitting slopes", stream, blocks, fit_slopes, input, arrays);
    launch("averaging slopes", stream, blocks, average_slopes<Record>, input, reading(arrays.fitted),
           records);
}
template void find_slopes(cudaStream_t, const RecordInput&, const SlopeArrays&,
                          const matching::RasterView<PixelRecord>&);
template void find_slopes(cudaStream_t, const RecordInput&, const SlopeArrays&,
                          const matching::RasterView<PlaneRecord>&);

}  // namespace hexrelief::cuda
