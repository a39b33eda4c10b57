#include "cuda/matching/common/pixel_list.cuh"
#include "cuda/matching/refine/fill.h"
#include "cuda/matching/refine/match_colors.cuh"
#include "cuda/matching/refine/record_access.cuh"

namespace hexrelief::cuda {
namespace {

constexpr unsigned kAllLanes = 0xffffffffu;
constexpr int kRows = 32;  // rows of the picture in a word of a column or diagonal

// Finds the known pixels of lines of one kind in 32 rows. The bits of a word are neighbouring pixels of a row
// in the picture's rows, and pixels of successive rows in columns and diagonals.
__global__ void find_known_kernel(matching::DisparityView map, KnownPixels known) {
    begin_kernel();
    const auto kind = static_cast<KnownPixels::Kind>(blockIdx.z);
    const int line = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x),
              first_y = static_cast<int>(blockIdx.y) * kRows, lines = known.lines(kind);
    if (line / 32 * 32 >= lines) return;  // a warp returns together
    std::uint32_t bits = 0;
#pragma unroll
    for (int j = 0; j < kRows; ++j) {
        const int y = first_y + j, x = known.x_of(kind, line, y);
        const bool is_known = y < map.height && x >= 0 && x < map.width && map.at(x, y) >= 0;
        bits |= static_cast<std::uint32_t>(is_known) << j;
        if (kind != KnownPixels::kColumns) continue;
        const std::uint32_t of_row = __ballot_sync(kAllLanes, is_known);
        if (threadIdx.x % 32 == 0 && y < map.height) known.rows.at(line / 32, y) = of_row;
    }
    if (line < lines) known.words[kind].at(line, static_cast<int>(blockIdx.y)) = bits;
}

// Returns the distance to the next set bit behind `place` on a line; 0 = there is none. words: the line's
// `count` words, `apart` from each other.
__device__ int distance_behind(const std::uint32_t* words, int count, int apart, int place) {
    int k = place / 32;
    std::uint32_t bits = words[k * apart] & (0xfffffffeu << place % 32);
    while (bits == 0) {
        if (++k == count) return 0;
        bits = words[k * apart];
    }
    return 32 * k + __ffs(static_cast<int>(bits)) - 1 - place;
}
// Returns the distance to the last set bit before `place`; 0 = there is none.
__device__ int distance_before(const std::uint32_t* words, int apart, int place) {
    int k = place / 32;
    std::uint32_t bits = words[k * apart] & ((1u << place % 32) - 1);
    while (bits == 0) {
        if (--k < 0) return 0;
        bits = words[k * apart];
    }
    return place - (32 * k + 31 - __clz(static_cast<int>(bits)));
}

// Returns the distance to the nearest known pixel in a direction; 0 = there is none.
__device__ int distance_to_known(const KnownPixels& known, int direction, int x, int y) {
    const int dx = step::direction_x(direction), dy = step::direction_y(direction);
    if (dy == 0) {
        const std::uint32_t* const words = known.rows.row(y);
        return dx > 0 ? distance_behind(words, known.rows.width, 1, x) : distance_before(words, 1, x);
    }
    const KnownPixels::Kind kind = dx == 0    ? KnownPixels::kColumns
                                   : dx == dy ? KnownPixels::kFalling
                                              : KnownPixels::kRising;
    const matching::RasterView<std::uint32_t>& lines = known.words[kind];
    const std::uint32_t* const words = lines.origin + known.line_of(kind, x, y);
    return dy > 0 ? distance_behind(words, lines.height, lines.stride, y)
                  : distance_before(words, lines.stride, y);
}

// The colour difference of the window around (x, y) and the one in the right picture at a disparity.
struct WindowDifference {
    const FillInput& in;
    int x, y;

    HEXRELIEF_HD int operator()(int disparity) const {
        return window_difference(in.left_colors, in.right_colors, x, y,
                                 step::position_in_right(x, in.min_px, disparity));
    }
};

// Returns the disparity with which an unknown pixel is filled.
__device__ std::int16_t filled_pixel(const FillInput& in, const KnownPixels& known, int x, int y) {
    int candidates[step::kDirections];
#pragma unroll
    for (int k = 0; k < step::kDirections; ++k) {
        const int distance = distance_to_known(known, k, x, y);
        candidates[k] = matching::kUnknown16;
        if (distance == 0) continue;
        const int dx = distance * step::direction_x(k), dy = distance * step::direction_y(k);
        const PixelRecord from = read_record(&in.records.at(x + dx, y + dy));
        candidates[k] = step::on_plane(from.disparity, slope_x(from), slope_y(from), -dx, -dy);
    }
    const step::FillSite site{x, in.right.width, in.min_px, in.nearest_seen.row(y), in.right.row(y)};
    return step::filled(site, candidates, WindowDifference{in, x, y});
}

__global__ void __launch_bounds__(kListBlock)
    fill_unknown_kernel(FillInput in, KnownPixels known, matching::DisparityOut map) {
    begin_kernel();
    for_each_listed(in.holes, [&](int x, int y) {
        if (map.at(x, y) == matching::kUnknown16) map.at(x, y) = filled_pixel(in, known, x, y);
    });
}

}  // namespace

KnownPixels take_known_pixels(Arena& arena, int width, int height) {
    KnownPixels known{width, height, {}, {}};
    known.rows = take_plain_raster<std::uint32_t>(arena, (width + 31) / 32, height);
    for (const auto kind : {KnownPixels::kColumns, KnownPixels::kFalling, KnownPixels::kRising})
        known.words[kind] =
            take_plain_raster<std::uint32_t>(arena, known.lines(kind), (height + kRows - 1) / kRows);
    return known;
}

void find_known(cudaStream_t stream, const matching::DisparityView& map, const KnownPixels& known) {
    constexpr int kBlock = 128;
    const dim3 grid(static_cast<unsigned>(
                        blocks_for(static_cast<std::size_t>(known.lines(KnownPixels::kFalling)), kBlock)),
                    static_cast<unsigned>((map.height + kRows - 1) / kRows), KnownPixels::kKinds);
    launch("finding known pixels", stream, {grid, kBlock}, find_known_kernel, map, known);
}

void fill_unknown(cudaStream_t stream, const FillInput& input, const KnownPixels& known,
                  const matching::DisparityOut& map) {
    launch("filling", stream, list_blocks(map.width, map.height), fill_unknown_kernel, input, known, map);
}

}  // namespace hexrelief::cuda
