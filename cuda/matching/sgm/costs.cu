#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/path_costs.cuh"
#include "cuda/matching/sgm/volume.h"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr int kTaken = 8;         // disparities of a thread, all in one run
constexpr int kPixelsOfRun = 16;  // successive pixels that a thread handles
template <int kRun>
constexpr int kThreads = 2 * kRun / kTaken;  // per pixel

struct CostInput {
    PackedColors left, right;
    matching::RasterView<const std::uint64_t> left_census, right_census;
};

// A row of both pictures.
struct Row {
    const std::uint64_t *left_census, *right_census;
    const std::uint32_t *left, *right;
    int width;
    matching::DisparityRange range;
};

struct Pixel {
    std::uint64_t census;
    std::uint32_t color;
};

// The columns of the right picture with which a pixel is compared, one per disparity of the thread. Most of
// them were also those of the preceding pixel and stay in registers: only the oldest one is replaced at each
// pixel; all are replaced if the window moves.
struct Columns {
    // The column of the first disparity is in the slot of the step, those of larger disparities in
    // the slots before it.
    Pixel pixels[kTaken];
    int first = -1;  // the first disparity

    // step: position of the pixel in groups of kTaken.
    __device__ void take(const Row& row, int x, int disparity, int step) {
        const int nearest = x - row.range.min_px - disparity;
        const auto take_column = [&](int k) {
            const int column = clamped(nearest - k, row.width);
            pixels[(step + kTaken - k) % kTaken] = {__ldg(row.right_census + column),
                                                    __ldg(row.right + column)};
        };
        take_column(0);
        if (disparity != first)
#pragma unroll
            for (int k = 1; k < kTaken; ++k) take_column(k);
        first = disparity;
    }
    // Returns the column of disparity first + k.
    __device__ const Pixel& at(int step, int k) const {
        return pixels[(step + kTaken - k) % kTaken];
    }
};

// Returns the costs of two neighbouring disparities, in the halves of a word.
template <int kChannels>
__device__ std::uint32_t costs_of_pair(const Pixel& own, const Pixel& first, const Pixel& second) {
    const auto hamming = [&](const Pixel& other) {
        return static_cast<std::uint32_t>(__popcll(own.census ^ other.census));
    };
    const std::uint32_t of_first = __vabsdiffu4(own.color, first.color),
                        of_second = __vabsdiffu4(own.color, second.color);
    std::uint32_t differences = 0;
#pragma unroll
    for (int c = 0; c < kChannels; ++c)  // byte c of both, with the fourth, which is 0, above each
        differences += step::cut_difference(__byte_perm(of_first, of_second, 0x3430 + 0x101 * c));
    return step::matching_cost(hamming(first) | hamming(second) << 16, differences, kChannels);
}

// Exchanges costs between two neighbouring threads, of which one has disparities of the far run and the
// other of the near run. Each gives half of its costs for half of the other's, because a path reads the
// bytes of both in turn.
__device__ uint2 exchanged(uint2 costs, bool near) {
    const unsigned threads = 0x3u << (threadIdx.x % 32 & ~1u);
    const std::uint32_t given = near ? costs.x : costs.y, kept = near ? costs.y : costs.x,
                        taken = __shfl_xor_sync(threads, given, 1);
    const std::uint32_t of_far = near ? taken : kept, of_near = near ? kept : taken;
    return {__byte_perm(of_far, of_near, 0x5140), __byte_perm(of_far, of_near, 0x7362)};
}

// Writes the costs of a thread's disparities for pixels first_x .. end_x - 1.
template <int kRun, int kChannels>
__device__ void find_costs_of_run(const Row& row, const PathPixel* pixels, int first_x, int end_x,
                                  uint2* out) {
    const bool near = threadIdx.x % 2 != 0;
    const int in_run = static_cast<int>(threadIdx.x) % kThreads<kRun> / 2 * kTaken;
    Columns others;
    for (int first = first_x; first < end_x; first += kTaken) {
#pragma unroll
        for (int step = 0; step < kTaken; ++step) {
            const int x = first + step;
            if (x >= end_x) break;
            const PathPixel pixel = pixels[x];
            others.take(row, x, (near ? near_run(pixel) : far_run(pixel)) + in_run, step);
            const Pixel own{__ldg(row.left_census + x), __ldg(row.left + x)};
            std::uint32_t pairs[kTaken / 2];
#pragma unroll
            for (int k = 0; k < kTaken / 2; ++k)
                pairs[k] = costs_of_pair<kChannels>(own, others.at(step, 2 * k), others.at(step, 2 * k + 1));
            if (others.first + kTaken > row.range.count)
#pragma unroll
                for (int k = 0; k < kTaken / 2; ++k) {
                    const int beyond = others.first + 2 * k - row.range.count;
                    if (beyond > -2)
                        pairs[k] |= (beyond < 0 ? 0 : matching::kBeyondRange) | matching::kBeyondRange << 16;
                }
            *out = exchanged(
                {__byte_perm(pairs[0], pairs[1], 0x6420), __byte_perm(pairs[2], pairs[3], 0x6420)}, near);
            out += kThreads<kRun>;
        }
    }
}

// kThreads threads handle a run of pixels of a row.
template <int kRun, int kChannels>
__global__ void __launch_bounds__(kBlock, 8) find_costs_kernel(CostInput in, DeviceVolume volume) {
    begin_kernel();
    const int run = static_cast<int>(blockIdx.x * kBlock + threadIdx.x) / kThreads<kRun>;
    const int y = volume.band.rows.first + static_cast<int>(blockIdx.y);
    const int first_x = run * kPixelsOfRun;
    if (first_x >= volume.width) return;
    const std::size_t first = static_cast<std::size_t>(blockIdx.y) * volume.width + first_x;
    if (volume.right_best)
        for (int i = static_cast<int>(threadIdx.x) % kThreads<kRun>;
             i < min(kPixelsOfRun, volume.width - first_x); i += kThreads<kRun>)
            volume.right_best[first + i] = kNoRightBest;
    const Row row{in.left_census.row(y), in.right_census.row(y), in.left.row(y),
                  in.right.row(y),       volume.width,           volume.range};
    std::uint8_t* const out = volume.costs + first * 2 * kRun;
    find_costs_of_run<kRun, kChannels>(row, volume.pixels.row(y), first_x,
                                       min(volume.width, first_x + kPixelsOfRun),
                                       reinterpret_cast<uint2*>(out) + threadIdx.x % kThreads<kRun>);
}

template <int kRun>
void find_costs_in_runs(cudaStream_t stream, const PairArrays& pair, const DeviceVolume& volume) {
    const std::size_t runs = static_cast<std::size_t>(blocks_for(volume.width, kPixelsOfRun));
    const dim3 grid(static_cast<unsigned>(blocks_for(runs * kThreads<kRun>, kBlock)),
                    static_cast<unsigned>(volume.band.rows.count()));
    const CostInput input{reading(pair.colors[0]), reading(pair.colors[1]), reading(pair.census[0]),
                          reading(pair.census[1])};
    const auto kernel = pair.channels == 3 ? find_costs_kernel<kRun, 3> : find_costs_kernel<kRun, 1>;
    launch("finding matching costs", stream, {grid, kBlock}, kernel, input, volume);
}

}  // namespace

void find_costs(cudaStream_t stream, const PairArrays& pair, const DeviceVolume& volume) {
    if (matching::is_searched_wholly(volume.range))
        find_costs_in_runs<matching::kLongRun>(stream, pair, volume);
    else
        find_costs_in_runs<matching::kShortRun>(stream, pair, volume);
}

}  // namespace hexrelief::cuda
