// Deliberate mistakes: inputs that people give instead of the correct ones.
#pragma once

#include <functional>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks::mistakes {

Image as_grey(const Image& image);
// Moves the picture to the right and down by `columns` and `rows`; the border is repeated.
Image shifted(const Image& image, int columns, int rows);
Image rotated(const Image& image, double degrees);
Image mirrored(const Image& image);
Image cropped(const Image& image, int width, int height, int x = 0, int y = 0);
// Replaces samples v by 255 * gain * (v / 255)^gamma, at most 255.
Image exposed(const Image& image, double gamma, double gain);
// Writes the picture as a JPEG of this quality and reads it again.
Image as_stored(const Image& image, int quality);
// Returns a picture of one grey with noise of +-amplitude.
Image plain(const Image& like, int grey, int amplitude, int seed);

// Adds a texture of blocks of `block` px to every surface alike, which hides the edges of things.
Image textured(const Image& image, int amplitude, int block);

// Fills unknown pixels with the smaller of the disparities at both sides in their row.
DisparityMap filled(DisparityMap map);
// Makes all things larger by some px on each side, as matchers of blocks do. The map knows all pixels.
DisparityMap enlarged(const DisparityMap& map, int px);
// Averages over squares of 2 * px + 1, which makes the wide edges of networks. The map knows all pixels.
DisparityMap blurred(const DisparityMap& map, int px);
// Reduces the map by a factor and enlarges it again, linearly. The map knows all pixels.
DisparityMap coarse(const DisparityMap& map, int factor);
DisparityMap cropped(const DisparityMap& map, int x, int y, int width, int height);

DisparityMap with_values(DisparityMap map, const std::function<double(double)>& value_of);
// Returns the grey of the colour map jet for a value from 0 to 255.
double grey_of_jet(double grey);

}  // namespace hexrelief::checks::mistakes
