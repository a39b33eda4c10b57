#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/costs.h"
#include "cuda/matching/sgm/path_costs.cuh"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr int kThreads = 2 * kGroup;  // of a pixel, one for each part of its window
constexpr int kPixelsOfRun = 16;      // that a thread takes one after the other

struct CostInput {
    PackedColors left, right;
    RasterView<const std::uint64_t> left_census, right_census;
    int min_px;
};

// A row of both pictures.
struct Row {
    const std::uint64_t *left_census, *right_census;
    const std::uint32_t *left, *right;
    int width, count, min_px;
};

struct Pixel {
    std::uint64_t census;
    std::uint32_t color;
};

// What a part of a window is compared with: of the right picture, as many columns as it has disparities. Most
// are those of the pixel before, and stay in registers: the oldest is replaced at each pixel; where the
// window moves, all are.
struct PartColumns {
    Pixel columns[kPart];  // that of the nearest disparity in the slot of the step, farther ones before it
    int part = -1;

    // step: kPart of them follow each other.
    __device__ void take(const Row& row, int x, int here, int step) {
        const int nearest = x - row.min_px - here * kPart;
        const auto take_column = [&](int k) {
            const int column = clamped(nearest - k, row.width);
            columns[(step + kPart - k) % kPart] = {__ldg(row.right_census + column),
                                                   __ldg(row.right + column)};
        };
        take_column(0);
        if (here != part)
#pragma unroll
            for (int k = 1; k < kPart; ++k) take_column(k);
        part = here;
    }
    // Entry k of the part.
    __device__ const Pixel& at(int step, int k) const {
        return columns[(step + kPart - k) % kPart];
    }
};

// The costs of two neighbouring disparities, side by side.
template <int kChannels>
__device__ std::uint32_t costs_of_pair(const Pixel& own, const Pixel& first, const Pixel& second) {
    const auto hamming = [&](const Pixel& other) {
        return static_cast<std::uint32_t>(__popcll(own.census ^ other.census));
    };
    return step::matching_costs_of_pair(
        hamming(first) | hamming(second) << 16,
        step::cut_differences_of_pair(own.color, first.color, second.color, kChannels), kChannels);
}

// Two threads have the parts of a lane of a path: `far` and `near` alternate. Each gives half of its costs
// for half of the other one's, as a path reads the bytes of both in turn.
__device__ uint2 exchanged(uint2 costs, bool near) {
    const unsigned threads = 0x3u << (threadIdx.x % 32 & ~1u);
    const std::uint32_t given = near ? costs.x : costs.y, kept = near ? costs.y : costs.x,
                        taken = __shfl_xor_sync(threads, given, 1);
    const std::uint32_t of_far = near ? taken : kept, of_near = near ? kept : taken;
    return {__byte_perm(of_far, of_near, 0x5140), __byte_perm(of_far, of_near, 0x7362)};
}

// Of pixels first_x .. end_x - 1, a thread's part.
template <int kChannels>
__device__ void find_costs_of_run(const Row& row, const PathPixel* pixels, int first_x, int end_x,
                                  uint2* out) {
    const bool near = threadIdx.x % 2 != 0;
    const int lane = static_cast<int>(threadIdx.x) % kThreads / 2;
    PartColumns others;
    for (int first = first_x; first < end_x; first += kPart) {
#pragma unroll
        for (int step = 0; step < kPart; ++step) {
            const int x = first + step;
            if (x >= end_x) break;
            const PathPixel pixel = pixels[x];
            others.take(row, x, (near ? near_part(pixel) : far_part(pixel)) + lane, step);
            const Pixel own{__ldg(row.left_census + x), __ldg(row.left + x)};
            std::uint32_t pairs[kPart / 2];
#pragma unroll
            for (int k = 0; k < kPart / 2; ++k) {
                pairs[k] = costs_of_pair<kChannels>(own, others.at(step, 2 * k), others.at(step, 2 * k + 1));
                const int beyond = others.part * kPart + 2 * k - row.count;
                if (beyond > -2) pairs[k] |= (beyond < 0 ? 0 : kBeyondRange) | kBeyondRange << 16;
            }
            *out = exchanged(
                {__byte_perm(pairs[0], pairs[1], 0x6420), __byte_perm(pairs[2], pairs[3], 0x6420)}, near);
            out += kThreads;
        }
    }
}

// Some threads take a run of pixels of a row.
template <int kChannels>
__global__ void __launch_bounds__(kBlock) find_costs_kernel(CostInput in, DeviceVolume volume) {
    const int run = static_cast<int>(blockIdx.x * kBlock + threadIdx.x) / kThreads;
    const int y = volume.band.rows.first + static_cast<int>(blockIdx.y);
    const int first_x = run * kPixelsOfRun;
    if (first_x >= volume.width) return;
    const Row row{in.left_census.row(y), in.right_census.row(y), in.left.row(y), in.right.row(y),
                  volume.width,          volume.count,           in.min_px};
    std::uint8_t* const out =
        volume.costs + (static_cast<std::size_t>(blockIdx.y) * volume.width + first_x) * kSearched;
    find_costs_of_run<kChannels>(row, volume.pixels.row(y), first_x,
                                 min(volume.width, first_x + kPixelsOfRun),
                                 reinterpret_cast<uint2*>(out) + threadIdx.x % kThreads);
}

}  // namespace

void find_costs(cudaStream_t stream, const PairArrays& pair, int min_px, const DeviceVolume& volume) {
    const std::size_t runs = static_cast<std::size_t>(blocks_for(volume.width, kPixelsOfRun));
    const dim3 grid(static_cast<unsigned>(blocks_for(runs * kThreads, kBlock)),
                    static_cast<unsigned>(volume.band.rows.count()));
    const CostInput input{reading(pair.colors[0]), reading(pair.colors[1]), reading(pair.census[0]),
                          reading(pair.census[1]), min_px};
    const auto kernel = pair.channels == 3 ? find_costs_kernel<3> : find_costs_kernel<1>;
    kernel<<<grid, kBlock, 0, stream>>>(input, volume);
    check_launch("finding matching costs");
}

}  // namespace hexrelief::cuda
