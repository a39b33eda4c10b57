// A picture as the matcher reads it: its channels one by one, and its luminance.
#pragma once

#include <array>

#include "mesher/common/thread_pool.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::matching {

// One channel of a grey picture, three of a colour one; the border repeats the picture's edge.
struct ColorPlanes {
    int channels = 1;
    std::array<Raster<std::uint8_t>, 3> planes;
    Raster<std::uint8_t> grey;

    int width() const { return grey.width(); }
    int height() const { return grey.height(); }
};

// Of a pair, with as many channels each.
struct PairColors {
    ColorPlanes left, right;
};

// The planes as steps take them.
struct ColorView {
    int channels;
    RasterView<const std::uint8_t> planes[3];
};

enum class Channels { as_they_are, grey };
ColorPlanes split_colors(const Image& image, Channels channels, ThreadPool& pool);
// Both as grey where their channels differ.
PairColors split_colors(const StereoPair& pair, ThreadPool& pool);
// Each channel as the mean of 3x3 pixels, which noise disturbs less; grey stays.
ColorPlanes blurred(const ColorPlanes& colors, ThreadPool& pool);
ColorView view_of(const ColorPlanes& colors);

}  // namespace hexrelief::matching
