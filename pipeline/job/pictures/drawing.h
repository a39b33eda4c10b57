// Anti-aliased drawing on 8-bit colour pictures. Coordinates are in px; the centre of pixel (x,
// y) is at +0.5.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/image.h"

namespace hexrelief::job {

using Rgb = std::array<std::uint8_t, 3>;

Image blank_picture(int width, int height, Rgb colour);
// Returns a picture of three channels from one of one or three, each pixel repeated factor x factor times.
Image enlarge_to_rgb(const Image& image, int factor);
// Draws a pixel, a line or a disc with opacity 0..1; parts outside the picture are ignored.
void blend_pixel(Image& picture, int x, int y, Rgb colour, float opacity);
void draw_segment(Image& picture, Vec2f a, Vec2f b, Rgb colour, float width_px, float opacity);
void draw_disc(Image& picture, Vec2f centre, Rgb colour, float radius_px, float opacity);

// Returns the shares of the weights (>= 0) in bins of W_k / mean, each 0.05 wide: bin i is centred at 0.05 i,
// the last one (2) holds all larger ones. Empty if there is no weight or all are 0.
std::vector<double> weight_shares(const std::vector<double>& weights);

// Draws the bins as bars from 0 (left) to 2 (right) times the mean, with lines at 0.5, 1 (red) and
// 1.5. A bar's height is proportional to the square root of its share, so that single cells are
// visible. 820 x 400 px.
Image weights_picture(const std::vector<double>& weights);

}  // namespace hexrelief::job
