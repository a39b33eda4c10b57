#include "pipeline/stages/density.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/error.h"
#include "pipeline/stages/density_detail.h"

namespace hexrelief::stages {
namespace {

constexpr std::uint32_t kHalf = 1u << 16;

// Counts, in 2^16 bins, the map's disparities that are known, above 0 and accepted by `counted`; and in one
// more bin all pixels.
template <typename Counted, typename Bin>
std::vector<long long> histogram(const MapInStrips& map, const Counted& counted, const Bin& bin) {
    std::vector<std::vector<long long>> parts(static_cast<std::size_t>(map.strips));
    for (std::vector<long long>& part : parts) part.resize(kHalf + 1);
    map.read([&](int strip, const MapWindow& window) {
        long long* const part = parts[static_cast<std::size_t>(strip)].data();
        part[kHalf] += static_cast<long long>(window.width) * window.height;
        for (int y = 0; y < window.height; ++y) {
            const float* const row = window.row(y);
            for (int x = 0; x < window.width; ++x) {
                const auto bits = std::bit_cast<std::uint32_t>(row[x]);
                if (DisparityMap::known(row[x]) && row[x] > 0 && counted(bits)) ++part[bin(bits)];
            }
        }
    });
    for (std::size_t k = 1; k < parts.size(); ++k)
        for (std::size_t i = 0; i <= kHalf; ++i) parts[0][i] += parts[k][i];
    return std::move(parts[0]);
}

// The disparities above 0 in ascending order. Positive floats are in the order of their bits, so the upper
// half of the bits is found first, then the lower half: several times as fast as std::nth_element.
class AscendingDisparities {
  public:
    explicit AscendingDisparities(const MapInStrips& map)
        : map_(map),
          upper_(histogram(
              map, [](std::uint32_t) { return true; }, [](std::uint32_t bits) { return bits / kHalf; })),
          count_(std::accumulate(upper_.begin(), upper_.end() - 1, 0LL)) {}

    long long count() const { return count_; }
    long long pixels() const { return upper_.back(); }  // of the whole map

    // Returns the disparity of a rank, which is from 1 to count().
    float at(long long rank) const {
        const auto bin_of_rank = [&rank](const std::vector<long long>& counts) {
            std::uint32_t bin = 0;
            while (rank > counts[bin]) rank -= counts[bin++];
            return bin;
        };
        const std::uint32_t high = bin_of_rank(upper_);
        const auto lower = histogram(
            map_, [&](std::uint32_t bits) { return bits / kHalf == high; },
            [](std::uint32_t bits) { return bits % kHalf; });
        return std::bit_cast<float>(high * kHalf + bin_of_rank(lower));
    }

  private:
    const MapInStrips& map_;
    std::vector<long long> upper_;
    long long count_;
};

// Returns the smallest disparity above 0 that at least `scale_percentile` % of the disparities above 0 do not
// exceed; 0 if there is none. For BackgroundMethod::automatic a patch that is less than 0.5 % of the picture
// and far in front of all else does not count: it is wrong, or a thing in the way.
float scale_of(const MapInStrips& map, const DensityConfig& config) {
    constexpr double kLeastPatch = 0.005, kFarInFront = 1.5;
    const AscendingDisparities disparities(map);
    const long long count = disparities.count();
    if (count == 0) return 0;
    const float scale = disparities.at(std::max(
        1LL, static_cast<long long>(std::ceil(config.scale_percentile / 100 * static_cast<double>(count)))));
    if (config.background_method != BackgroundMethod::automatic) return scale;
    const auto patch =
        static_cast<long long>(std::ceil(kLeastPatch * static_cast<double>(disparities.pixels())));
    const float behind = disparities.at(std::max(1LL, count + 1 - patch));
    return scale > kFarInFront * behind ? behind : scale;
}

// Otsu's threshold on 256 bins of the known disparities: the split that maximises the variance
// between the two classes.
double otsu_threshold(const MapInStrips& map, float largest) {
    constexpr int kBins = 256;
    std::vector<std::array<long long, kBins>> parts(static_cast<std::size_t>(map.strips));
    const double to_bin = kBins / static_cast<double>(largest);
    map.read([&](int strip, const MapWindow& window) {
        std::array<long long, kBins>& part = parts[static_cast<std::size_t>(strip)];
        for (int y = 0; y < window.height; ++y)
            for (const float d : std::span(window.row(y), static_cast<std::size_t>(window.width)))
                if (DisparityMap::known(d))
                    ++part[std::clamp(static_cast<int>(std::floor(d * to_bin)), 0, kBins - 1)];
    });
    std::array<long long, kBins> histogram{};
    for (const auto& part : parts)
        for (int i = 0; i < kBins; ++i) histogram[i] += part[i];
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
            last = i;  // an empty bin changes nothing: split in the middle of a gap, not at its edge
        }
    }
    if (best < 0) return 0;  // one value only: nothing separates background from foreground
    return (0.5 * (first + last) + 1) / to_bin;
}

// The border between the pixels below a threshold and the others, counted in pairs of neighbours in a row or
// a column. Unknown pixels between two known ones are skipped: a hole neither connects nor separates.
struct Border {
    float threshold;
    long long length = 0;           // pairs of neighbours on the border
    long long discontinuous = 0;    // pairs at a depth discontinuity
    long long known = 0, kept = 0;  // known pixels, and those not below the threshold

    void add(float a, float b, int distance_px) {
        if ((a < threshold) == (b < threshold)) return;
        const float nearer = std::max(a, b), farther = std::min(a, b);
        ++length;
        // The farther surface is at least twice as far away. The difference also exceeds noise and rounding,
        // and what a steep plane rises by over this distance. Left of a near object as many pixels are hidden
        // as the disparity steps by, so half a pixel of disparity for each is on the safe side.
        const float least = std::max({1.0f, 0.5f * nearer, 0.5f * static_cast<float>(distance_px)});
        discontinuous += nearer - farther >= least;
    }
};

// The last known pixel of a row or a column.
struct Seen {
    int at = -1;  // x or y; -1: none so far
    float disparity = 0;

    // Adds the border between this pixel and the next known one, at position `next`, which takes its place.
    void pass(Border& border, int next, float d) {
        if (at >= 0) border.add(disparity, d, next - at);
        at = next;
        disparity = d;
    }
};

Border border_at(const MapInStrips& map, float threshold) {
    struct Strip {
        Border border;
        std::vector<Seen> above;                       // last known pixel of each column
        std::vector<std::pair<Seen, Seen>> ends = {};  // first and last known pixel of each row
    };
    std::vector<Strip> strips(static_cast<std::size_t>(map.strips), {{threshold}, {}});
    map.read([&](int k, const MapWindow& window) {
        Strip& strip = strips[static_cast<std::size_t>(k)];
        Border border = strip.border;
        strip.above.resize(static_cast<std::size_t>(window.width));
        for (int y = 0; y < window.height; ++y) {
            const float* const row = window.row(y);
            Seen first, left;
            for (int x = 0; x < window.width; ++x) {
                const float d = row[x];
                if (!DisparityMap::known(d)) continue;
                ++border.known;
                border.kept += d >= border.threshold;
                left.pass(border, window.x + x, d);
                strip.above[static_cast<std::size_t>(x)].pass(border, window.y + y, d);
                if (first.at < 0) first = left;
            }
            strip.ends.emplace_back(first, left);
        }
        strip.border = border;
    });
    Border whole{threshold};
    for (const Strip& strip : strips) {
        whole.length += strip.border.length;
        whole.discontinuous += strip.border.discontinuous;
        whole.known += strip.border.known;
        whole.kept += strip.border.kept;
    }
    for (std::size_t y = 0; y < strips[0].ends.size(); ++y) {
        Seen left;
        for (const Strip& strip : strips) {
            const auto& [first, last] = strip.ends[y];
            if (first.at < 0) continue;
            left.pass(whole, first.at, first.disparity);
            left = last;
        }
    }
    return whole;
}

// Returns `candidate` if the disparities below it are separated from the rest, else 0; 0 as well if they are
// nearly all, because then the picture is of them, and what is nearer is some wrong patch or a thing in the
// way.
float separating_threshold(const MapInStrips& map, float candidate) {
    constexpr double kLeastDiscontinuousShare = 0.8, kLeastKeptShare = 0.1;
    const Border border = border_at(map, candidate);
    if (border.kept < kLeastKeptShare * border.known) return 0;
    return border.discontinuous >= kLeastDiscontinuousShare * border.length ? candidate : 0;
}

double background_threshold(const MapInStrips& map, const DensityConfig& config, float scale) {
    switch (config.background_method) {
        case BackgroundMethod::none:
            return 0;
        case BackgroundMethod::automatic:
            return separating_threshold(map, static_cast<float>(config.background_fraction * scale));
        case BackgroundMethod::fraction:
            return config.background_fraction * scale;
        case BackgroundMethod::threshold_px:
            return config.background_threshold_px;
        case BackgroundMethod::otsu:
            return otsu_threshold(map, scale);
    }
    return 0;
}

// A power of which whole exponents need only products: the C library's pow() differs between its versions
// in the last bit.
double power(double base, double exponent) {
    const int whole = static_cast<int>(exponent);
    if (whole != exponent) return std::pow(base, exponent);
    double product = 1;
    for (int i = 0; i < whole; ++i) product *= base;
    return product;
}

void check(const DensityConfig& config) {
    using Config = DensityConfig;
    const std::string outside = out_of_range({
        {"density.exponent", config.exponent, Config::kExponent},
        {"density.scale_percentile", config.scale_percentile, Config::kScalePercentile},
        {"density.background.fraction", config.background_fraction, Config::kBackgroundFraction},
        {"density.background.threshold_px", config.background_threshold_px, Config::kBackgroundThreshold_px},
        {"density.floor", config.floor, Config::kFloor},
        {"density.detail", config.detail, Config::kDetail},
    });
    if (!outside.empty()) throw Error(ErrorKind::usage, outside);
}

// Mixes densities: (1 - share) of the sum is the density's, `share` the detail's; the largest value becomes
// 1. The density does not change if there is no detail.
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

DensityScale find_density_scale(const MapInStrips& map, const DensityConfig& config) {
    check(config);
    DensityScale found{.scale_px = scale_of(map, config)};
    // Rounded to the float that is handed on, so that every later stage draws the same line.
    if (found.scale_px > 0)
        found.background_px = static_cast<float>(background_threshold(map, config, found.scale_px));
    return found;
}

DensityMap density_at_scale(const DisparityMap& part, const DensityScale& scale, const DensityConfig& config,
                            int threads) {
    DensityMap density{part.width, part.height, std::vector<float>(part.values.size(), 0.0f),
                       scale.background_px};
    if (!(scale.scale_px > 0)) return density;
    const float floor = static_cast<float>(config.floor);
    const auto fill = [&](const auto& power_of) {
        ThreadPool(threads).parallel_for(part.values.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                const float d = part.values[i];
                const bool known = DisparityMap::known(d);
                const double share = static_cast<double>(std::min(d, scale.scale_px)) / scale.scale_px;
                const float near = std::max(static_cast<float>(power_of(share)), floor);
                const bool foreground = known & (d > 0) & (d >= scale.background_px);
                density.values[i] = foreground ? near : known ? floor : 0.0f;
            }
        });
    };
    if (config.exponent == 3)  // nearly always; this loop is several times as fast
        fill([](double share) { return share * share * share; });
    else
        fill([&](double share) { return power(share, config.exponent); });
    return density;
}

DensityMap compute_density(const DisparityMap& map, const DensityConfig& config, int threads) {
    ThreadPool pool(threads);
    const auto read = [&](const auto& take) {
        pool.run([&](int strip) {
            const auto column = [&](int of) {
                return static_cast<int>(pool.share(static_cast<std::size_t>(map.width), of));
            };
            const int x = column(strip);
            take(strip, {x, 0, column(strip + 1) - x, map.height, map.values.data() + x,
                         static_cast<std::size_t>(map.width)});
        });
    };
    const DensityScale scale = find_density_scale({pool.size(), read}, config);
    DensityMap density = density_at_scale(map, scale, config, threads);
    if (config.detail > 0) mix(density.values, detail_density(map, density.background_px), config.detail);
    return density;
}

}  // namespace hexrelief::stages
