#include "cuda/matching/refine/fill.h"
#include "cuda/matching/refine/match_colors.cuh"
#include "cuda/matching/refine/record_access.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr unsigned kAllLanes = 0xffffffffu;
constexpr int kSweeps = 6;              // directions that lead to another row
constexpr int kRays = 32, kParts = 16;  // of a block; each thread takes a part of a ray
constexpr std::int16_t kOutside = -2;
static_assert(kUnknown16 == -1);

// Down (or up) the rows, along a column or a diagonal; the direction leads the other way. Rays that begin
// outside of the picture come in at its side.
struct Ray {
    const DisparityView& map;
    int dx, dy, first_x;

    __device__ Ray(const DisparityView& all, int direction, int number)
        : map(all), dx(step::direction_x(direction)), dy(step::direction_y(direction)) {
        first_x = dx < 0 ? number - (map.height - 1) : number;
    }
    // Of the i-th row.
    __device__ int x(int i) const { return first_x - i * dx; }
    __device__ int y(int i) const { return dy < 0 ? i : map.height - 1 - i; }
    __device__ std::int16_t at(int i) const {
        const bool inside = i >= 0 && i < map.height && x(i) >= 0 && x(i) < map.width;
        return inside ? map.at(x(i), y(i)) : kOutside;
    }
};

// First each thread finds the last known pixel of its part, so that the next ones know how far back theirs
// is.
__global__ void __launch_bounds__(kRays* kParts, 3) sweep_rows(DisparityView map, FillArrays arrays) {
    constexpr int kAtOnce = 8;  // reads that are under way
    __shared__ int last_known[kParts][kRays];
    const int number = static_cast<int>(blockIdx.y),
              direction = number < 4 ? 1 + number : 2 + number;  // not E, W
    const Ray ray(map, direction, static_cast<int>(blockIdx.x * kRays + threadIdx.x));
    const int rows = (map.height + kParts - 1) / kParts, part = static_cast<int>(threadIdx.y);
    const int begin = part * rows, end = min(map.height, begin + rows);
    int last = -1;
    for (int i = end - 1; i >= begin && last < 0; i -= kAtOnce) {
        std::int16_t values[kAtOnce];
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j) values[j] = ray.at(i - j);
#pragma unroll
        for (int j = kAtOnce - 1; j >= 0; --j)
            if (i - j >= begin && values[j] >= 0) last = i - j;
    }
    last_known[part][threadIdx.x] = last;
    __syncthreads();
    last = -1;
    for (int before = part - 1; before >= 0 && last < 0; --before) last = last_known[before][threadIdx.x];
    int distance =
        last < 0 ? 0 : begin - last;  // of the next pixel to the nearest known one; 0 = there is none
    std::uint16_t* const distances = arrays.distances[direction];
    for (int i = begin; i < end; i += kAtOnce) {
        std::int16_t values[kAtOnce];
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j) values[j] = i + j < end ? ray.at(i + j) : kOutside;
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j) {
            if (values[j] >= 0) distance = 1;
            if (values[j] != kUnknown16) continue;
            distances[static_cast<std::size_t>(ray.y(i + j)) * map.width + ray.x(i + j)] =
                static_cast<std::uint16_t>(distance);
            if (distance > 0) ++distance;
        }
    }
}

// A warp a row, both ways.
__global__ void __launch_bounds__(kBlock) sweep_columns(DisparityView map, FillArrays arrays) {
    constexpr int kWest = 5, kAtOnce = 4;
    const int y = static_cast<int>((blockIdx.x * kBlock + threadIdx.x) / 32),
              lane = static_cast<int>(threadIdx.x % 32);
    if (y >= map.height) return;
    const std::int16_t* const row = map.row(y);
    const std::size_t at = static_cast<std::size_t>(y) * map.width;
    const int chunks = (map.width + 31) / 32;
    // known(chunk): its pixels that are, a bit each
    const auto sweep = [&](bool to_east) {
        std::uint16_t* const distances = arrays.distances[to_east ? kWest : step::kEast] + at;
        int last = -1;  // the known pixel that was passed last
        for (int first = 0; first < chunks; first += kAtOnce) {
            bool unknown[kAtOnce];
#pragma unroll
            for (int j = 0; j < kAtOnce; ++j) {
                const int x = 32 * (to_east ? first + j : chunks - 1 - first - j) + lane;
                unknown[j] = x < 0 || x >= map.width || row[x] == kUnknown16;
            }
#pragma unroll
            for (int j = 0; j < kAtOnce; ++j) {
                const int chunk = to_east ? first + j : chunks - 1 - first - j, x = 32 * chunk + lane;
                const unsigned known = __ballot_sync(kAllLanes, !unknown[j]);
                const unsigned passed = to_east      ? known & ((1u << lane) - 1)
                                        : lane == 31 ? 0
                                                     : known & (kAllLanes << (lane + 1));
                const auto nearest_of = [&](unsigned lanes) {
                    const int bit = static_cast<int>(lanes);
                    return 32 * chunk + (to_east ? 31 - __clz(bit) : __ffs(bit) - 1);
                };
                const int nearest = passed ? nearest_of(passed) : last;
                if (x >= 0 && x < map.width && unknown[j])
                    distances[x] = static_cast<std::uint16_t>(nearest < 0 ? 0 : abs(x - nearest));
                if (known) last = nearest_of(known);
            }
        }
    };
    sweep(true);
    sweep(false);
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
        candidates[k] = kUnknown16;
        if (distance == 0) continue;
        const int dx = distance * step::direction_x(k), dy = distance * step::direction_y(k);
        const PixelRecord known = read_record(&in.records.at(at.x + dx, at.y + dy));
        candidates[k] = step::on_plane(known.disparity, slope_x(known), slope_y(known), -dx, -dy);
    }
    const step::FillSite site{at.x, in.map.width, in.min_px, in.nearest_seen.row(at.y), in.right.row(at.y)};
    filled.at(at.x, at.y) = step::filled(site, candidates, WindowDifference{in, at.x, at.y});
}

}  // namespace

void find_known(cudaStream_t stream, const DisparityView& map, const FillArrays& arrays) {
    const int width = map.width, height = map.height;
    const dim3 grid(static_cast<unsigned>(blocks_for(static_cast<std::size_t>(width) + height, kRays)),
                    kSweeps);
    sweep_rows<<<grid, dim3(kRays, kParts), 0, stream>>>(map, arrays);
    check_launch("finding known pixels");
    sweep_columns<<<blocks_for(static_cast<std::size_t>(height) * 32, kBlock), kBlock, 0, stream>>>(map,
                                                                                                    arrays);
    check_launch("finding known pixels");
}

void fill_unknown(cudaStream_t stream, const FillInput& input, const FillArrays& arrays,
                  const DisparityOut& filled) {
    fill_unknown_kernel<<<pixel_grid(input.map.width, input.map.height), pixel_block(), 0, stream>>>(
        input, arrays, filled);
    check_launch("filling");
}

}  // namespace hexrelief::cuda
