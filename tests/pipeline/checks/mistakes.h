// Mistakes made on purpose: what people hand over in place of what they should.
#pragma once

#include <functional>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks::mistakes {

Image as_grey(const Image& image);
// The picture `columns` and `rows` farther right and down; what comes in repeats the border.
Image shifted(const Image& image, int columns, int rows);
Image rotated(const Image& image, double degrees);
Image mirrored(const Image& image);
Image cropped(const Image& image, int width, int height);
// Samples v become 255 * gain * (v / 255)^gamma, at most 255.
Image exposed(const Image& image, double gamma, double gain);
// Written as a JPEG of this quality and read again.
Image as_stored(const Image& image, int quality);
// One grey with noise of +-amplitude.
Image plain(const Image& like, int grey, int amplitude, int seed);

DisparityMap with_values(DisparityMap map, const std::function<double(double)>& value_of);
// Of a grey from 0 to 255: what the grey of the colour map jet is.
double grey_of_jet(double grey);

}  // namespace hexrelief::checks::mistakes
