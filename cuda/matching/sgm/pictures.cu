#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/pictures.h"
#include "pipeline/matching/common/half_size_step.h"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief::cuda {
namespace {

// blockIdx.z of each kernel: left, right.
dim3 grid_of_both(int width, int height) {
    dim3 grid = pixel_grid(width, height);
    grid.z = 2;
    return grid;
}

struct HalfPixels {
    std::uint8_t* pixels[2];
};

__global__ void halve_kernel(PairPixels pair, int width, int height, HalfPixels halves) {
    const int2 at = pixel_of_thread();
    const int half_width = step::half_size(width);
    if (at.x >= half_width || at.y >= step::half_size(height)) return;
    const std::uint8_t* const pixels = pair.pixels[blockIdx.z];
    const int channels = pair.channels[blockIdx.z];
    const std::size_t left = step::first_covered(at.x), right = step::second_covered(at.x, width);
    const std::size_t above = static_cast<std::size_t>(step::first_covered(at.y)) * width,
                      below = static_cast<std::size_t>(step::second_covered(at.y, height)) * width;
    std::uint8_t* const out =
        halves.pixels[blockIdx.z] + (static_cast<std::size_t>(at.y) * half_width + at.x) * channels;
    for (int c = 0; c < channels; ++c) {
        const auto value = [&](std::size_t pixel) { return __ldg(pixels + pixel * channels + c); };
        out[c] = step::rounded_mean(value(above + left), value(above + right), value(below + left),
                                    value(below + right));
    }
}

// Also writes the border of grey.
__global__ void split_channels(PairPixels pair, PairArrays arrays) {
    const int2 at = pixel_of_thread();
    const int x = at.x - kBorder_px, y = at.y - kBorder_px, width = arrays.width, height = arrays.height;
    if (x >= width + kBorder_px || y >= height + kBorder_px) return;
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

// The census transform of a 9x7 window (Zabih & Woodfill 1994): a bit says whether a pixel is darker than the
// centre. A thread takes four pixels of a row, the bytes of a word each; of eight neighbours the bits make a
// word, whose byte k is pixel k's.
constexpr int kAtOnce = 4;
constexpr std::uint32_t kHighBits = 0x80808080u;

// The high bits of those bytes that are less.
__device__ std::uint32_t less(std::uint32_t bytes, std::uint32_t than) {
    const std::uint32_t low_not_less = (bytes | kHighBits) - (than & ~kHighBits);
    return ((~bytes & than) | (~(bytes ^ than) & ~low_not_less)) & kHighBits;
}

// Byte k of each of four words, for the words k.
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
    const int2 at = pixel_of_thread();
    const int x = kAtOnce * at.x;
    if (x >= arrays.width || at.y >= arrays.height) return;
    static_assert(step::kCensusRadiusX == kAtOnce && step::kCensusBits <= 64);
    const RasterView<std::uint8_t>& grey = arrays.grey[blockIdx.z];
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

void halve(cudaStream_t stream, const PairPixels& pair, int width, int height, std::uint8_t* const half[2]) {
    halve_kernel<<<grid_of_both(step::half_size(width), step::half_size(height)), pixel_block(), 0, stream>>>(
        pair, width, height, {{half[0], half[1]}});
    check_launch("halving the pictures");
}

void prepare_pair(cudaStream_t stream, const PairPixels& pair, const PairArrays& arrays) {
    const int width = arrays.width, height = arrays.height;
    split_channels<<<grid_of_both(width + 2 * kBorder_px, height + 2 * kBorder_px), pixel_block(), 0,
                     stream>>>(pair, arrays);
    check_launch("splitting colours");
    find_census<<<grid_of_both(blocks_for(width, kAtOnce), height), pixel_block(), 0, stream>>>(arrays);
    check_launch("the census transform");
}

}  // namespace hexrelief::cuda
