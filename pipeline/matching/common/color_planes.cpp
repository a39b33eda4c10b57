#include "pipeline/matching/common/color_planes.h"

#include <algorithm>

#include "mesher/common/simd.h"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/common/rows.h"

namespace hexrelief {
namespace {

void fill_row(const Image& image, int y, ColorPlanes& colors) {
    const int source = std::clamp(y, 0, image.height - 1);
    for (int x = -kBorder_px; x < image.width + kBorder_px; ++x) {
        const std::uint8_t* pixel = image.at(std::clamp(x, 0, image.width - 1), source);
        const std::uint8_t grey =
            image.channels == 3 ? step::luminance(pixel[0], pixel[1], pixel[2]) : pixel[0];
        colors.grey.view().at(x, y) = grey;
        for (int c = 0; c < colors.channels; ++c)
            colors.planes[c].view().at(x, y) = colors.channels == 3 ? pixel[c] : grey;
    }
}

HEXRELIEF_SMALL_VECTORS void blur_row(RasterView<const std::uint8_t> plane, int y,
                                      std::uint8_t* __restrict out) {
    const std::uint8_t *above = plane.row(y - 1), *own = plane.row(y), *below = plane.row(y + 1);
    for (int x = 0; x < plane.width; ++x) {
        const int left = above[x - 1] + own[x - 1] + below[x - 1], middle = above[x] + own[x] + below[x],
                  right = above[x + 1] + own[x + 1] + below[x + 1];
        out[x] = step::rounded_ninth(static_cast<std::uint16_t>(left + middle + right));
    }
}

}  // namespace

ColorPlanes split_colors(const Image& image, Channels channels, ThreadPool& pool) {
    ColorPlanes colors;
    colors.channels = channels == Channels::grey ? 1 : image.channels;
    for (int c = 0; c < colors.channels; ++c)
        colors.planes[c] = Raster<std::uint8_t>(image.width, image.height, 0);
    colors.grey = Raster<std::uint8_t>(image.width, image.height, 0);
    for_each_row(pool, image.height + 2 * kBorder_px,
                 [&](int row) { fill_row(image, row - kBorder_px, colors); });
    return colors;
}

PairColors split_colors(const StereoPair& pair, ThreadPool& pool) {
    const Channels channels =
        pair.left.channels == pair.right.channels ? Channels::as_they_are : Channels::grey;
    return {split_colors(pair.left, channels, pool), split_colors(pair.right, channels, pool)};
}

ColorPlanes blurred(const ColorPlanes& colors, ThreadPool& pool) {
    ColorPlanes result = colors;
    for (int c = 0; c < colors.channels; ++c)
        for_each_row(pool, colors.height(),
                     [&](int y) { blur_row(colors.planes[c].view(), y, result.planes[c].view().row(y)); });
    return result;
}

ColorView view_of(const ColorPlanes& colors) {
    ColorView view{colors.channels, {}};
    for (int c = 0; c < 3; ++c) view.planes[c] = colors.planes[c < colors.channels ? c : 0].view();
    return view;
}

}  // namespace hexrelief
