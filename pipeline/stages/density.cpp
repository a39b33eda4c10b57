#include "pipeline/stages/density.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "mesher/common/thread_pool.h"
#include "pipeline/data/error.h"
#include "pipeline/stages/density_detail.h"

namespace hexrelief {
namespace {

constexpr std::uint32_t kHalf = 1u << 16;

// How many of the map's disparities that are known, above 0 and `counted` fall into each of 2^16 bins.
template <typename Counted, typename Bin>
std::vector<long long> histogram(const MapInBands& map, ThreadPool& pool, const Counted& counted,
                                 const Bin& bin) {
    std::vector<std::vector<long long>> parts(static_cast<std::size_t>(pool.size()));
    for (std::vector<long long>& part : parts) part.resize(kHalf);
    map([&](const DisparityMap& band) {
        pool.run([&](int thread) {
            std::vector<long long>& part = parts[static_cast<std::size_t>(thread)];
            const std::size_t end = pool.share(band.values.size(), thread + 1);
            for (std::size_t i = pool.share(band.values.size(), thread); i < end; ++i) {
                const float d = band.values[i];
                const auto bits = std::bit_cast<std::uint32_t>(d);
                if (DisparityMap::known(d) && d > 0 && counted(bits)) ++part[bin(bits)];
            }
        });
    });
    for (std::size_t k = 1; k < parts.size(); ++k)
        for (std::size_t i = 0; i < kHalf; ++i) parts[0][i] += parts[k][i];
    return std::move(parts[0]);
}

// The smallest disparity above 0 that at least `percentile` % of these do not exceed; 0 without any.
float percentile_above_zero(const MapInBands& map, double percentile, ThreadPool& pool) {
    // Positive floats are in the order of their bits, so the upper half of these is found first, then the
    // lower: several times as fast as std::nth_element.
    const auto upper = histogram(
        map, pool, [](std::uint32_t) { return true; }, [](std::uint32_t bits) { return bits / kHalf; });
    const long long count = std::accumulate(upper.begin(), upper.end(), 0LL);
    if (count == 0) return 0;
    auto rank =
        std::max(1LL, static_cast<long long>(std::ceil(percentile / 100 * static_cast<double>(count))));
    const auto bin_of_rank = [&rank](const std::vector<long long>& counts) {
        std::uint32_t bin = 0;
        while (rank > counts[bin]) rank -= counts[bin++];
        return bin;
    };
    const std::uint32_t high = bin_of_rank(upper);
    const auto lower = histogram(
        map, pool, [&](std::uint32_t bits) { return bits / kHalf == high; },
        [](std::uint32_t bits) { return bits % kHalf; });
    return std::bit_cast<float>(high * kHalf + bin_of_rank(lower));
}

// Otsu's threshold on 256 bins of the known disparities: the split with the largest variance between the two
// classes.
double otsu_threshold(const MapInBands& map, float largest) {
    constexpr int kBins = 256;
    std::array<long long, kBins> histogram{};
    const double to_bin = kBins / static_cast<double>(largest);
    map([&](const DisparityMap& band) {
        for (const float d : band.values)
            if (DisparityMap::known(d))
                ++histogram[std::clamp(static_cast<int>(std::floor(d * to_bin)), 0, kBins - 1)];
    });
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

// The border between what is below a threshold and what is not, in pairs of neighbours in a row or a column.
// Unknown pixels are looked across: a hole neither connects nor parts.
struct Border {
    float threshold;
    long long length = 0;         // pairs
    long long discontinuous = 0;  // pairs at a depth discontinuity

    void add(float a, float b, int distance_px) {
        if ((a < threshold) == (b < threshold)) return;
        const float nearer = std::max(a, b), farther = std::min(a, b);
        ++length;
        // What is behind is at least twice as far away, by more than noise and rounding, and by more than a
        // steep plane climbs over this distance. Left of a near object as many pixels are hidden as the
        // disparity steps by, so half a pixel of disparity for each is on the safe side.
        const float least = std::max({1.0f, 0.5f * nearer, 0.5f * static_cast<float>(distance_px)});
        discontinuous += nearer - farther >= least;
    }
};

// Rows and columns are walked on their own, each thread along some of them.
Border border_at(const MapInBands& map, float threshold, ThreadPool& pool) {
    struct Seen {
        int y = -1;  // -1: nothing known so far
        float disparity = 0;
    };
    std::vector<Border> parts(static_cast<std::size_t>(pool.size()), Border{threshold});
    std::vector<Seen> above;  // of each column, the known pixel seen last
    int top = 0;              // row of the band's first
    map([&](const DisparityMap& band) {
        above.resize(static_cast<std::size_t>(band.width));
        pool.run([&](int thread) {
            const auto share = [&](int size, int of) {
                return static_cast<int>(pool.share(static_cast<std::size_t>(size), of));
            };
            Border border = parts[static_cast<std::size_t>(thread)];
            for (int y = share(band.height, thread); y < share(band.height, thread + 1); ++y) {
                int left = -1;
                for (int x = 0; x < band.width; ++x) {
                    const float d = band.at(x, y);
                    if (!DisparityMap::known(d)) continue;
                    if (left >= 0) border.add(band.at(left, y), d, x - left);
                    left = x;
                }
            }
            const int first = share(band.width, thread), end = share(band.width, thread + 1);
            for (int y = 0; y < band.height; ++y)
                for (int x = first; x < end; ++x) {
                    const float d = band.at(x, y);
                    if (!DisparityMap::known(d)) continue;
                    Seen& last = above[static_cast<std::size_t>(x)];
                    if (last.y >= 0) border.add(last.disparity, d, top + y - last.y);
                    last = {top + y, d};
                }
            parts[static_cast<std::size_t>(thread)] = border;
        });
        top += band.height;
    });
    Border whole{threshold};
    for (const Border& part : parts) {
        whole.length += part.length;
        whole.discontinuous += part.discontinuous;
    }
    return whole;
}

// `candidate` where what is below it is apart from the rest, else 0.
float separating_threshold(const MapInBands& map, float candidate, ThreadPool& pool) {
    constexpr double kLeastDiscontinuousShare = 0.8;
    const Border border = border_at(map, candidate, pool);
    return border.discontinuous >= kLeastDiscontinuousShare * border.length ? candidate : 0;
}

double background_threshold(const MapInBands& map, const DensityConfig& config, float scale,
                            ThreadPool& pool) {
    switch (config.background_method) {
        case BackgroundMethod::none:
            return 0;
        case BackgroundMethod::automatic:
            return separating_threshold(map, static_cast<float>(config.background_fraction * scale), pool);
        case BackgroundMethod::fraction:
            return config.background_fraction * scale;
        case BackgroundMethod::threshold_px:
            return config.background_threshold_px;
        case BackgroundMethod::otsu:
            return otsu_threshold(map, scale);
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
    if (!inside(config.scale_percentile, 0, 100))
        throw Error(ErrorKind::usage, "density.scale_percentile must be between 0 and 100");
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

DensityScale find_density_scale(const MapInBands& map, const DensityConfig& config, int threads) {
    check(config);
    ThreadPool pool(threads);
    DensityScale found;
    found.scale_px = percentile_above_zero(map, config.scale_percentile, pool);
    // Compared as the float that is handed on, so that every later stage draws the same line.
    if (found.scale_px > 0)
        found.background_px = static_cast<float>(background_threshold(map, config, found.scale_px, pool));
    return found;
}

DensityMap density_at_scale(const DisparityMap& part, const DensityScale& scale, const DensityConfig& config,
                            int threads) {
    DensityMap density{part.width, part.height, std::vector<float>(part.values.size(), 0.0f),
                       scale.background_px};
    if (!(scale.scale_px > 0)) return density;
    const float floor = static_cast<float>(config.floor);
    ThreadPool pool(threads);
    pool.parallel_for(part.values.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            const float d = part.values[i];
            if (!DisparityMap::known(d)) continue;
            density.values[i] = floor;
            if (!(d > 0) || d < scale.background_px) continue;
            const double share = static_cast<double>(std::min(d, scale.scale_px)) / scale.scale_px;
            density.values[i] = std::max(static_cast<float>(power(share, config.exponent)), floor);
        }
    });
    return density;
}

DensityMap compute_density(const DisparityMap& map, const DensityConfig& config, int threads) {
    const DensityScale scale = find_density_scale([&](const auto& take) { take(map); }, config, threads);
    DensityMap density = density_at_scale(map, scale, config, threads);
    if (config.detail > 0) mix(density.values, detail_density(map, density.background_px), config.detail);
    return density;
}

}  // namespace hexrelief
