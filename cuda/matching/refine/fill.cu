#include "cuda/matching/refine/fill.h"
#include "cuda/matching/refine/match_colors.cuh"
#include "cuda/matching/refine/record_access.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr unsigned kAllLanes = 0xffffffffu;
constexpr int kSweeps = 6;  // directions that lead to another row

// A thread goes down (or up) the rows, along a column or a diagonal. Diagonals that begin outside of the
// picture come in at its side.
__global__ void __launch_bounds__(kBlock) sweep_rows(DisparityView map, FillArrays arrays) {
    constexpr int kAtOnce = 8;  // reads that are under way
    const int number = static_cast<int>(blockIdx.y);
    const int k = number < 4 ? 1 + number : 2 + number;  // all but E and W
    const int dx = step::direction_x(k), dy = step::direction_y(k);
    // The sweep goes against the direction: from the row that it leads to.
    const int thread = static_cast<int>(blockIdx.x * kBlock + threadIdx.x);
    const int first_x = dx == 0 ? thread : dx < 0 ? thread - (map.height - 1) : thread;
    if (dx == 0 ? thread >= map.width : thread >= map.width + map.height - 1) return;
    std::uint16_t* const distances = arrays.distances[k];
    int distance = 0;  // of the pixel before to the nearest known one; 0 = there is none
    for (int i = 0; i < map.height; i += kAtOnce) {
        std::int16_t values[kAtOnce];
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j) {
            const int x = first_x - (i + j) * dx, y = dy < 0 ? i + j : map.height - 1 - (i + j);
            const bool inside = i + j < map.height && x >= 0 && x < map.width;
            values[j] = inside ? map.at(x, y) : std::int16_t{-2};
        }
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j) {
            const int x = first_x - (i + j) * dx, y = dy < 0 ? i + j : map.height - 1 - (i + j);
            if (values[j] == -2) {
                distance = 0;
            } else if (values[j] != kUnknown16) {
                distance = 1;
            } else {
                distances[static_cast<std::size_t>(y) * map.width + x] = static_cast<std::uint16_t>(distance);
                if (distance > 0) ++distance;
            }
        }
    }
}

// A warp a row, both ways.
__global__ void __launch_bounds__(kBlock) sweep_columns(DisparityView map, FillArrays arrays) {
    constexpr int kWest = 5;
    const int y = static_cast<int>((blockIdx.x * kBlock + threadIdx.x) / 32),
              lane = static_cast<int>(threadIdx.x % 32);
    if (y >= map.height) return;
    const std::int16_t* const row = map.row(y);
    const std::size_t at = static_cast<std::size_t>(y) * map.width;
    const int chunks = (map.width + 31) / 32;
    int last = -1;
    for (int chunk = 0; chunk < chunks; ++chunk) {
        const int x = 32 * chunk + lane;
        const std::int16_t own = x < map.width ? row[x] : kUnknown16;
        const unsigned known = __ballot_sync(kAllLanes, own != kUnknown16);
        const unsigned before = known & ((1u << lane) - 1);
        const int nearest = before ? 32 * chunk + 31 - __clz(static_cast<int>(before)) : last;
        if (x < map.width && own == kUnknown16)
            arrays.distances[kWest][at + x] = static_cast<std::uint16_t>(nearest < 0 ? 0 : x - nearest);
        if (known) last = 32 * chunk + 31 - __clz(static_cast<int>(known));
    }
    last = -1;
    for (int chunk = chunks - 1; chunk >= 0; --chunk) {
        const int x = 32 * chunk + lane;
        const std::int16_t own = x < map.width ? row[x] : kUnknown16;
        const unsigned known = __ballot_sync(kAllLanes, own != kUnknown16);
        const unsigned behind = lane == 31 ? 0 : known & (kAllLanes << (lane + 1));
        const int nearest = behind ? 32 * chunk + __ffs(static_cast<int>(behind)) - 1 : last;
        if (x < map.width && own == kUnknown16)
            arrays.distances[step::kEast][at + x] = static_cast<std::uint16_t>(nearest < 0 ? 0 : nearest - x);
        if (known) last = 32 * chunk + __ffs(static_cast<int>(known)) - 1;
    }
}

struct WindowDifference {
    const FillInput& in;
    int x, y;

    HEXRELIEF_HD int operator()(int disparity) const {
        return window_difference(in.left_colors, in.right_colors, x, y,
                                 step::position_in_right(x, in.min_px, disparity));
    }
};

__global__ void fill_unknown_kernel(FillInput in, FillArrays arrays, DisparityOut filled) {
    const int2 at = pixel_of_thread();
    if (at.x >= in.map.width || at.y >= in.map.height) return;
    const std::int16_t own = in.map.at(at.x, at.y);
    if (own != kUnknown16) {
        filled.at(at.x, at.y) = own;
        return;
    }
    const std::size_t pixel = static_cast<std::size_t>(at.y) * in.map.width + at.x;
    int candidates[step::kDirections];
#pragma unroll
    for (int k = 0; k < step::kDirections; ++k) {
        const int distance = arrays.distances[k][pixel];
        const int dx = distance * step::direction_x(k), dy = distance * step::direction_y(k);
        const PixelRecord known = read_record(&in.records.at(at.x + dx, at.y + dy));
        candidates[k] = distance == 0
                            ? kUnknown16
                            : step::on_plane(known.disparity, known.slope_x, known.slope_y, -dx, -dy);
    }
    const step::FillSite site{at.x, in.map.width, in.min_px, in.nearest_seen.row(at.y), in.right.row(at.y)};
    filled.at(at.x, at.y) = step::filled(site, candidates, WindowDifference{in, at.x, at.y});
}

}  // namespace

void fill_unknown(cudaStream_t stream, const FillInput& input, const FillArrays& arrays,
                  const DisparityOut& filled) {
    const int width = input.map.width, height = input.map.height;
    const dim3 grid(static_cast<unsigned>(blocks_for(static_cast<std::size_t>(width) + height, kBlock)),
                    kSweeps);
    sweep_rows<<<grid, kBlock, 0, stream>>>(input.map, arrays);
    check_launch("finding known pixels");
    sweep_columns<<<blocks_for(static_cast<std::size_t>(height) * 32, kBlock), kBlock, 0, stream>>>(input.map,
                                                                                                    arrays);
    check_launch("finding known pixels");
    fill_unknown_kernel<<<pixel_grid(width, height), pixel_block(), 0, stream>>>(input, arrays, filled);
    check_launch("filling");
}

}  // namespace hexrelief::cuda
