#include "cuda/matching/common/borders.h"

#include <algorithm>

#include "cuda/matching/common/launch.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr std::size_t kMostBorders = 16;  // largest number in a launch

struct Borders {
    Border borders[kMostBorders];
};

// blockIdx: (row of a raster, raster).
__global__ void __launch_bounds__(kBlock) fill_borders_kernel(const __grid_constant__ Borders all) {
    begin_kernel();
    const Border& border = all.borders[blockIdx.y];
    const int row = static_cast<int>(blockIdx.x);
    if (row >= border.height + 2 * matching::kBorder_px) return;
    const int row_bytes = border.stride * border.pixel_bytes;
    std::uint8_t* const bytes = border.first_row + static_cast<std::size_t>(row) * row_bytes;
    const bool crosses = row >= matching::kBorder_px && row < border.height + matching::kBorder_px;
    // bytes of the picture within the row, which are not touched
    const int begin = crosses ? matching::kBorder_px * border.pixel_bytes : row_bytes;
    const int end = crosses ? (matching::kBorder_px + border.width) * border.pixel_bytes : row_bytes;
    const std::uint32_t word = border.byte * 0x01010101u;
    const int last_whole = (end + 3) / 4 * 4;
    const auto fill_words = [&](int first, int past) {
        for (int i = first + 4 * static_cast<int>(threadIdx.x); i < past; i += 4 * kBlock)
            *reinterpret_cast<std::uint32_t*>(bytes + i) = word;
    };
    fill_words(0, begin);
    fill_words(last_whole, row_bytes);
    const int i = end + static_cast<int>(threadIdx.x);
    if (i < last_whole) bytes[i] = border.byte;
}

}  // namespace

void fill_borders(cudaStream_t stream, const std::vector<Border>& borders) {
    for (std::size_t first = 0; first < borders.size(); first += kMostBorders) {
        const std::size_t count = std::min(kMostBorders, borders.size() - first);
        Borders some;
        std::copy_n(borders.begin() + static_cast<std::ptrdiff_t>(first), count, some.borders);
        int rows = 0;
        for (const Border& border : borders) rows = std::max(rows, border.height + 2 * matching::kBorder_px);
        launch("filling borders", stream,
               {dim3(static_cast<unsigned>(rows), static_cast<unsigned>(count)), kBlock}, fill_borders_kernel,
               some);
    }
}

}  // namespace hexrelief::cuda
