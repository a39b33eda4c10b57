#include "pipeline/job/pictures/weights_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/job/pictures/drawing.h"

namespace hexrelief::job {
namespace {

constexpr int kBins = 41, kBinsOfMean = 20;
constexpr int kBar_px = 20, kHeight_px = 400, kMargin_px = 10;

void fill(Image& picture, int x0, int x1, int y0, int y1, Rgb colour) {
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) blend_pixel(picture, x, y, colour, 1);
}

}  // namespace

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
