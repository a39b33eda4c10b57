#include "pipeline/stages/dequantize/noise.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace hexrelief::stages {
namespace {

constexpr int kStride_px = 6;
// Third differences of white noise, with weights 1, 3, 3, 1, have 20 times its variance, and the median of
// their sizes is 0.6745 times their standard deviation.
constexpr double kMedianOfNoise = 3.0164;
constexpr int kBinsPerPixel = 16, kMost_px = 4;
constexpr long long kLeastCount = 1000;

// Counts the sizes of third differences, rounded to bins.
struct Sizes {
    std::array<long long, std::size_t{kBinsPerPixel} * kMost_px + 1> bins{};
    long long count = 0;

    void add(double size_px) {
        const double bin = std::floor(kBinsPerPixel * size_px + 0.5);
        ++bins[bin < static_cast<double>(bins.size()) ? static_cast<std::size_t>(bin) : bins.size() - 1];
        ++count;
    }
    // Sizes are evenly spread over their bin.
    double median_px() const {
        double left = 0.5 * static_cast<double>(count);
        std::size_t bin = 0;
        while (left > static_cast<double>(bins[bin])) left -= static_cast<double>(bins[bin++]);
        const double within = bins[bin] > 0 ? left / static_cast<double>(bins[bin]) : 0;
        return (static_cast<double>(bin) - 0.5 + within) / kBinsPerPixel;
    }
};

}  // namespace

double find_noise_px(const DisparityMap& map) {
    Sizes sizes;
    const auto add = [&](int x, int y, int dx, int dy) {
        double d[4];
        for (int k = 0; k < 4; ++k) {
            const std::size_t at = static_cast<std::size_t>(y + k * dy) * map.width + (x + k * dx);
            if (map.origins[at] != PixelOrigin::matched) return;
            d[k] = map.values[at];
        }
        sizes.add(std::abs(d[3] - 3 * d[2] + 3 * d[1] - d[0]));
    };
    constexpr int kReach_px = 3 * kStride_px;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if (x + kReach_px < map.width) add(x, y, kStride_px, 0);
            if (y + kReach_px < map.height) add(x, y, 0, kStride_px);
        }
    if (sizes.count < kLeastCount) return 0;
    const double noise_px = sizes.median_px() / kMedianOfNoise;
    return noise_px > 0 ? noise_px : 0;
}

NoiseSmoothing smoothing_for(double noise_px, double least_px) {
    if (noise_px < least_px) return {};
    return {noise_px, 7 * noise_px};
}

}  // namespace hexrelief::stages
