// The form in which the matcher reads a picture, its channels one by one and its luminance, and the colour
// steps in it.
#pragma once

#include <array>
#include <cstdint>

#include "pipeline/base/simd.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::matching {

// The planes of a picture: one channel if it is grey, three if it has colours. The border
// repeats the picture's edge.
struct ColorPlanes {
    int channels = 1;
    std::array<Raster<std::uint8_t>, 3> planes;
    Raster<std::uint8_t> grey;

    int width() const { return grey.width(); }
    int height() const { return grey.height(); }
};

// The planes of a pair; both views have the same number of channels.
struct PairColors {
    ColorPlanes left, right;
};

// Views of the planes, the form in which the step functions take them.
struct ColorView {
    int channels;
    RasterView<const std::uint8_t> planes[3];
};

enum class Channels { as_they_are, grey };
// Splits a picture into its channels and computes its luminance.
ColorPlanes split_colors(const Image& image, Channels channels, ThreadPool& pool);
// Splits both pictures; as grey ones if their numbers of channels differ.
PairColors split_colors(const StereoPair& pair, ThreadPool& pool);
// Returns each channel as the mean of 3x3 pixels, which noise disturbs less; the luminance is unchanged.
ColorPlanes blurred(const ColorPlanes& colors, ThreadPool& pool);
ColorView view_of(const ColorPlanes& colors);

// Returns a picture of (width + 1) / 2 x (height + 1) / 2 pixels, each the rounded mean of 2x2 pixels;
// the edge is repeated.
Image at_half_size(const Image& image, ThreadPool& pool);

// Sets out[x] to the largest difference of a channel between pixel (x0 + x, y) and the pixel (dx, dy) px
// away, in loops that the compiler vectorises.
HEXRELIEF_INLINED void color_steps(const ColorView& colors, int x0, int y, int dx, int dy, int count,
                                   std::uint8_t* __restrict out) {
    for (int c = 0; c < colors.channels; ++c) {
        const std::uint8_t* own = colors.planes[c].row(y) + x0;
        const std::uint8_t* other = colors.planes[c].row(y + dy) + x0 + dx;
        if (c == 0) {
            for (int x = 0; x < count; ++x) out[x] = step::distance(own[x], other[x]);
            continue;
        }
        for (int x = 0; x < count; ++x) {
            const std::uint8_t difference = step::distance(own[x], other[x]);
            out[x] = difference > out[x] ? difference : out[x];
        }
    }
}

}  // namespace hexrelief::matching
