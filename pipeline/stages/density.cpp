#include "pipeline/stages/density.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/data/error.h"
#include "pipeline/stages/density_detail.h"

namespace hexrelief {
namespace {

float largest_known(const DisparityMap& map) {
    float largest = 0;
    for (const float d : map.values) {
        if (DisparityMap::known(d)) largest = std::max(largest, d);
    }
    return largest;
}

// Otsu's threshold on 256 bins of the known disparities: the split with the largest variance between the two
// classes.
double otsu_threshold(const DisparityMap& map, float largest) {
    constexpr int kBins = 256;
    std::array<long long, kBins> histogram{};
    const double to_bin = kBins / static_cast<double>(largest);
    for (const float d : map.values) {
        if (!DisparityMap::known(d)) continue;
        ++histogram[std::clamp(static_cast<int>(std::floor(d * to_bin)), 0, kBins - 1)];
    }
    double total = 0, sum = 0;
    for (int i = 0; i < kBins; ++i) {
        total += static_cast<double>(histogram[i]);
        sum += static_cast<double>(i) * histogram[i];
    }
    double below = 0, below_sum = 0, best = -1;
    int first = 0, last = 0;
    for (int i = 0; i + 1 < kBins; ++i) {
        below += static_cast<double>(histogram[i]);
        below_sum += static_cast<double>(i) * histogram[i];
        const double above = total - below;
        if (below == 0 || above == 0) continue;
        const double gap = below_sum / below - (sum - below_sum) / above;
        const double between = below * above * gap * gap;
        if (between > best) {
            best = between;
            first = last = i;
        } else if (histogram[i] == 0 && last == i - 1) {
            last = i;  // an empty bin changes nothing: split in the middle of the gap, not at its edge
        }
    }
    if (best < 0) return 0;  // one value only: nothing tells background from foreground
    return (0.5 * (first + last) + 1) / to_bin;
}

double background_threshold(const DisparityMap& map, const DensityConfig& config, float largest) {
    switch (config.background_method) {
        case BackgroundMethod::none:
            return 0;
        case BackgroundMethod::fraction:
            return config.background_fraction * largest;
        case BackgroundMethod::threshold_px:
            return config.background_threshold_px;
        case BackgroundMethod::otsu:
            return otsu_threshold(map, largest);
    }
    return 0;
}

// pow() of the C library differs between its versions in the last bit; whole exponents need only products.
double power(double base, double exponent) {
    const int whole = static_cast<int>(exponent);
    if (whole != exponent) return std::pow(base, exponent);
    double product = 1;
    for (int i = 0; i < whole; ++i) product *= base;
    return product;
}

void check(const DensityConfig& config) {
    const auto inside = [](double value, double low, double high) { return value >= low && value <= high; };
    if (!inside(config.exponent, 0, 8))
        throw Error(ErrorKind::usage, "density.exponent must be between 0 and 8");
    if (!inside(config.background_fraction, 0, 1)) {
        throw Error(ErrorKind::usage, "density.background.fraction must be between 0 and 1");
    }
    if (!inside(config.floor, 0, 1)) throw Error(ErrorKind::usage, "density.floor must be between 0 and 1");
    if (!inside(config.detail, 0, 0.99))
        throw Error(ErrorKind::usage, "density.detail must be between 0 and 0.99");
    if (!std::isfinite(config.background_threshold_px)) {
        throw Error(ErrorKind::usage, "density.background.threshold_px must be a finite number of pixels");
    }
}

// (1 - share) of the density's sum, `share` of the detail's, the largest value 1 again. Without any detail
// the density stays.
void mix(std::vector<float>& density, const std::vector<float>& detail, double share) {
    double cube_sum = 0, detail_sum = 0;
    for (std::size_t i = 0; i < density.size(); ++i) cube_sum += density[i], detail_sum += detail[i];
    if (!(cube_sum > 0) || !(detail_sum > 0)) return;
    const double scale = share / (1 - share) * cube_sum / detail_sum;
    double largest = 0;
    for (std::size_t i = 0; i < density.size(); ++i)
        largest = std::max(largest, density[i] + scale * detail[i]);
    for (std::size_t i = 0; i < density.size(); ++i)
        density[i] = static_cast<float>((density[i] + scale * detail[i]) / largest);
}

}  // namespace

DensityMap compute_density(const DisparityMap& map, const DensityConfig& config) {
    check(config);
    DensityMap density{map.width, map.height, std::vector<float>(map.values.size(), 0.0f), 0};
    const float largest = largest_known(map);
    if (!(largest > 0)) return density;
    // Compared as the float that is handed on, so that every later stage draws the same line.
    density.background_px = static_cast<float>(background_threshold(map, config, largest));
    const float least = static_cast<float>(config.floor);
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        const float d = map.values[i];
        if (!DisparityMap::known(d)) continue;
        float value = 0;
        if (d > 0 && d >= density.background_px) {
            value = static_cast<float>(power(static_cast<double>(d) / largest, config.exponent));
        }
        density.values[i] = std::max(value, least);
    }
    if (config.detail > 0) mix(density.values, detail_density(map, density.background_px), config.detail);
    return density;
}

}  // namespace hexrelief
