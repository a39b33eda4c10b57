#include "cuda/matching/sgm/pictures.h"

#include <algorithm>

#include "cuda/matching/common/pixels.cuh"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::cuda {
namespace {

// blockIdx.z of each kernel: left, right.
Blocks blocks_of_both(int width, int height) {
    return pixel_blocks(width, height, 2);
}

// Side of the square that a block halves: at each size it keeps the smaller square in shared memory
// for the next size.
constexpr int kHalfTile_px = 32, kMostChannels = 3;
struct Halvings {
    HalvedPixels halved[kMostHalvings];
    int count;
};

__global__ void halve_kernel(PairPixels pair, int width, int height,
                             const __grid_constant__ Halvings halvings) {
    begin_kernel();
    __shared__ std::uint8_t tiles[2][kHalfTile_px * kHalfTile_px * kMostChannels];
    const int channels = pair.channels[blockIdx.z];
    for (int i = 0, side = kHalfTile_px; i < halvings.count; ++i, side /= 2) {
        const int first_x = static_cast<int>(blockIdx.x) * side,
                  first_y = static_cast<int>(blockIdx.y) * side;
        const int half_width = step::half_size(width), half_height = step::half_size(height);
        // the larger picture: all of it in device memory, or the block's square in shared memory
        const std::uint8_t* const from = i == 0 ? pair.pixels[blockIdx.z] : tiles[i % 2];
        const int from_x = i == 0 ? 0 : 2 * first_x, from_y = i == 0 ? 0 : 2 * first_y,
                  from_width = i == 0 ? width : 2 * side;
        std::uint8_t *const out = halvings.halved[i].pixels[blockIdx.z], *const tile = tiles[1 - i % 2];
        for (int k = static_cast<int>(threadIdx.y * 32 + threadIdx.x); k < side * side; k += 32 * 8) {
            const int x = first_x + k % side, y = first_y + k / side;
            if (x >= half_width || y >= half_height) continue;
            const auto at = [&](int column, int row) {
                return from +
                       (static_cast<std::size_t>(row - from_y) * from_width + column - from_x) * channels;
            };
            const int left = step::first_covered(x), right = step::second_covered(x, width),
                      above = step::first_covered(y), below = step::second_covered(y, height);
            for (int c = 0; c < channels; ++c) {
                const std::uint8_t mean = step::rounded_mean(at(left, above)[c], at(right, above)[c],
                                                             at(left, below)[c], at(right, below)[c]);
                out[(static_cast<std::size_t>(y) * half_width + x) * channels + c] = mean;
                tile[k * channels + c] = mean;
            }
        }
        width = half_width;
        height = half_height;
        __syncthreads();
    }
}

// Splits the pictures into colours and grey, including the border of grey.
__global__ void split_channels(PairPixels pair, PairArrays arrays) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    const int x = at.x - matching::kBorder_px, y = at.y - matching::kBorder_px, width = arrays.width,
              height = arrays.height;
    if (x >= width + matching::kBorder_px || y >= height + matching::kBorder_px) return;
    const std::size_t source = static_cast<std::size_t>(clamped(y, height)) * width + clamped(x, width);
    const int channels = pair.channels[blockIdx.z];
    const std::uint8_t* const pixel = pair.pixels[blockIdx.z] + source * channels;
    const std::uint8_t first = __ldg(pixel), second = channels == 3 ? __ldg(pixel + 1) : first,
                       third = channels == 3 ? __ldg(pixel + 2) : first;
    const std::uint8_t luminance = channels == 3 ? step::luminance(first, second, third) : first;
    arrays.grey[blockIdx.z].at(x, y) = luminance;
    if (x < 0 || x >= width || y < 0 || y >= height) return;
    arrays.colors[blockIdx.z].at(x, y) = arrays.channels == 1
                                             ? luminance * 0x010101u
                                             : first | second << 8 | static_cast<unsigned>(third) << 16;
}

// The census transform of a 9x7 window (Zabih & Woodfill 1994): each bit says whether a pixel is darker than
// the centre. A thread handles four pixels of a row, as the bytes of a word; the bits of eight neighbours
// make up a word whose byte k belongs to pixel k.
constexpr int kAtOnce = 4;
constexpr std::uint32_t kHighBits = 0x80808080u;

// Returns a word with the high bit set in each byte of `bytes` that is less than that of `than`.
__device__ std::uint32_t less(std::uint32_t bytes, std::uint32_t than) {
    const std::uint32_t low_not_less = (bytes | kHighBits) - (than & ~kHighBits);
    return ((~bytes & than) | (~(bytes ^ than) & ~low_not_less)) & kHighBits;
}

// Transposes four words of four bytes.
__device__ void transpose(const std::uint32_t* words, std::uint32_t (&bytes)[kAtOnce]) {
    const std::uint32_t even[2] = {__byte_perm(words[0], words[1], 0x6240),
                                   __byte_perm(words[2], words[3], 0x6240)},
                        odd[2] = {__byte_perm(words[0], words[1], 0x7351),
                                  __byte_perm(words[2], words[3], 0x7351)};
    bytes[0] = __byte_perm(even[0], even[1], 0x5410);
    bytes[1] = __byte_perm(odd[0], odd[1], 0x5410);
    bytes[2] = __byte_perm(even[0], even[1], 0x7632);
    bytes[3] = __byte_perm(odd[0], odd[1], 0x7632);
}

__global__ void find_census(PairArrays arrays) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    const int x = kAtOnce * at.x;
    if (x >= arrays.width || at.y >= arrays.height) return;
    static_assert(step::kCensusRadiusX == kAtOnce && step::kCensusBits <= 64);
    const matching::RasterView<std::uint8_t>& grey = arrays.grey[blockIdx.z];
    const auto row = [&](int j) { return reinterpret_cast<const std::uint32_t*>(&grey.at(x, at.y + j)); };
    const std::uint32_t centre = *row(0);
    std::uint32_t words[8] = {};
    int bit = 0;
#pragma unroll
    for (int j = -step::kCensusRadiusY; j <= step::kCensusRadiusY; ++j) {
        const std::uint32_t before = row(j)[-1], here = row(j)[0], behind = row(j)[1];
#pragma unroll
        for (int i = -step::kCensusRadiusX; i <= step::kCensusRadiusX; ++i) {
            if (i == 0 && j == 0) continue;
            const std::uint32_t others = i < 0 ? __funnelshift_rc(before, here, 8 * (kAtOnce + i))
                                               : __funnelshift_rc(here, behind, 8 * i);
            words[bit / 8] = words[bit / 8] >> 1 | less(others, centre);
            ++bit;
        }
    }
    std::uint32_t low[kAtOnce], high[kAtOnce];
    transpose(words, low);
    transpose(words + 4, high);
    uint4* const out = reinterpret_cast<uint4*>(&arrays.census[blockIdx.z].at(x, at.y));
    out[0] = make_uint4(low[0], high[0], low[1], high[1]);
    out[1] = make_uint4(low[2], high[2], low[3], high[3]);
}

}  // namespace

PairArrays take_pair_arrays(Arena& arena, const DeviceColors& colors) {
    PairArrays arrays{};
    arrays.width = colors.left.width;
    arrays.height = colors.left.height;
    arrays.channels = colors.in_color ? 3 : 1;
    arrays.colors[0] = colors.left;
    arrays.colors[1] = colors.right;
    for (int i = 0; i < 2; ++i) {
        arrays.census[i] =
            take_plain_raster<std::uint64_t>(arena, in_whole_words(arrays.width), arrays.height);
        arrays.grey[i] = take_bordered_raster<std::uint8_t>(arena, arrays.width, arrays.height);
    }
    return arrays;
}

void halve(cudaStream_t stream, const PairPixels& pair, int width, int height,
           const std::vector<HalvedPixels>& halved) {
    Halvings halvings{{}, static_cast<int>(halved.size())};
    std::copy(halved.begin(), halved.end(), halvings.halved);
    const auto blocks = [](int pixels) {
        return static_cast<unsigned>(blocks_for(static_cast<std::size_t>(pixels), 2 * kHalfTile_px));
    };
    launch("halving the pictures", stream, {{blocks(width), blocks(height), 2}, {32, 8}}, halve_kernel, pair,
           width, height, halvings);
}

void prepare_pair(cudaStream_t stream, const PairPixels& pair, const PairArrays& arrays) {
    const int width = arrays.width, height = arrays.height;
    launch("splitting colours", stream,
           blocks_of_both(width + 2 * matching::kBorder_px, height + 2 * matching::kBorder_px),
           split_channels, pair, arrays);
    launch("the census transform", stream, blocks_of_both(blocks_for(width, kAtOnce), height), find_census,
           arrays);
}

}  // namespace hexrelief::cuda
