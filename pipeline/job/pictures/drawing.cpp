#include "pipeline/job/pictures/drawing.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hexrelief::job {
namespace {

constexpr int kBins = 41, kBinsOfMean = 20;
constexpr int kBar_px = 20, kHeight_px = 400, kMargin_px = 10;

void fill(Image& picture, int x0, int x1, int y0, int y1, Rgb colour) {
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) blend_pixel(picture, x, y, colour, 1);
}

}  // namespace

Image blank_picture(int width, int height, Rgb colour) {
    Image picture{width, height, 3, {}};
    picture.pixels.resize(static_cast<std::size_t>(width) * height * 3);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = colour[i % 3];
    return picture;
}

Image enlarge_to_rgb(const Image& image, int factor) {
    Image picture = blank_picture(image.width * factor, image.height * factor, {0, 0, 0});
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const std::uint8_t* from = image.at(x / factor, y / factor);
            for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = from[image.channels == 1 ? 0 : c];
        }
    return picture;
}

void blend_pixel(Image& picture, int x, int y, Rgb colour, float opacity) {
    if (x < 0 || y < 0 || x >= picture.width || y >= picture.height || opacity <= 0) return;
    std::uint8_t* pixel = picture.at(x, y);
    for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(
            std::lround(pixel[c] + (colour[c] - pixel[c]) * std::min(opacity, 1.0f)));
}

void draw_segment(Image& picture, Vec2f a, Vec2f b, Rgb colour, float width_px, float opacity) {
    const float reach = 0.5f * width_px + 0.5f;  // half the line, and half a pixel of decreasing coverage
    const int x0 = std::max(0, static_cast<int>(std::floor(std::min(a.x, b.x) - reach)));
    const int x1 = std::min(picture.width - 1, static_cast<int>(std::floor(std::max(a.x, b.x) + reach)));
    const int y0 = std::max(0, static_cast<int>(std::floor(std::min(a.y, b.y) - reach)));
    const int y1 = std::min(picture.height - 1, static_cast<int>(std::floor(std::max(a.y, b.y) + reach)));
    const float dx = b.x - a.x, dy = b.y - a.y;
    const float length2 = dx * dx + dy * dy;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const float px = x + 0.5f - a.x, py = y + 0.5f - a.y;
            const float t = length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0f, 1.0f) : 0.0f;
            const float ex = px - t * dx, ey = py - t * dy;
            const float distance2 = ex * ex + ey * ey;
            if (distance2 >= reach * reach) continue;
            blend_pixel(picture, x, y, colour, opacity * std::min(1.0f, reach - std::sqrt(distance2)));
        }
}

void draw_disc(Image& picture, Vec2f centre, Rgb colour, float radius_px, float opacity) {
    draw_segment(picture, centre, centre, colour, 2 * radius_px, opacity);
}

std::vector<double> weight_shares(const std::vector<double>& weights) {
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (!(sum > 0)) return {};
    const double count = static_cast<double>(weights.size());
    std::vector<double> shares(kBins);
    for (const double w : weights) {
        const double bin = std::floor(w / sum * count * kBinsOfMean + 0.5);
        shares[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))] += 1 / count;
    }
    return shares;
}

Image weights_picture(const std::vector<double>& weights) {
    Image picture = blank_picture(kBins * kBar_px, kHeight_px, {255, 255, 255});
    const std::vector<double> shares = weight_shares(weights);
    const int foot = kHeight_px - kMargin_px;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        const double height = std::sqrt(shares[i]) * (foot - kMargin_px);
        const int left = static_cast<int>(i) * kBar_px;
        fill(picture, left + 1, left + kBar_px - 1, foot - static_cast<int>(std::ceil(height)), foot,
             {33, 100, 140});
    }
    fill(picture, 0, picture.width, foot, foot + 1, {60, 60, 60});
    for (const int bin : {10, 20, 30}) {
        const int middle = bin * kBar_px + kBar_px / 2;
        const Rgb colour = bin == kBinsOfMean ? Rgb{200, 60, 40} : Rgb{190, 190, 190};
        fill(picture, middle, middle + 1, 0, kHeight_px, colour);
    }
    return picture;
}

}  // namespace hexrelief::job
