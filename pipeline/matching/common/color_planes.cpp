#include "pipeline/matching/common/color_planes.h"

#include <algorithm>

namespace hexrelief::matching {
namespace {

// Fills the border of a plane's row by repeating the pixels at its ends.
void fill_border(std::uint8_t* row, int width) {
    std::fill_n(row - kBorder_px, kBorder_px, row[0]);
    std::fill_n(row + width, kBorder_px, row[width - 1]);
}

HEXRELIEF_SMALL_VECTORS void fill_row(const Image& image, int y, ColorPlanes& colors) {
    const int width = image.width, channels = image.channels;
    const std::uint8_t* pixels = image.at(0, std::clamp(y, 0, image.height - 1));
    std::uint8_t* grey = colors.grey.view().row(y);
    if (channels == 3)
        for (int x = 0; x < width; ++x)
            grey[x] = step::luminance(pixels[3 * x], pixels[3 * x + 1], pixels[3 * x + 2]);
    else
        for (int x = 0; x < width; ++x) grey[x] = pixels[channels * x];
    fill_border(grey, width);
    for (int c = 0; c < colors.channels; ++c) {
        std::uint8_t* plane = colors.planes[c].view().row(y);
        if (colors.channels == 3)
            for (int x = 0; x < width; ++x) plane[x] = pixels[3 * x + c];
        else
            std::copy_n(grey, width, plane);
        fill_border(plane, width);
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

Image at_half_size(const Image& image, ThreadPool& pool) {
    Image half{step::half_size(image.width), step::half_size(image.height), image.channels, {}};
    half.pixels.resize(static_cast<std::size_t>(half.width) * half.height * half.channels);
    for_each_row(pool, half.height, [&](int y) {
        const std::uint8_t* above = image.at(0, step::first_covered(y));
        const std::uint8_t* below = image.at(0, step::second_covered(y, image.height));
        std::uint8_t* out = half.at(0, y);
        for (int x = 0; x < half.width; ++x) {
            const int left = step::first_covered(x) * image.channels;
            const int right = step::second_covered(x, image.width) * image.channels;
            for (int c = 0; c < image.channels; ++c)
                *out++ =
                    step::rounded_mean(above[left + c], above[right + c], below[left + c], below[right + c]);
        }
    });
    return half;
}

}  // namespace hexrelief::matching
