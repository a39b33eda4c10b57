#include "pipeline/stages/dequantize/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <mutex>

#include "pipeline/base/thread_pool.h"

namespace hexrelief::stages {
namespace {

// Share of a quantum. Raw samples divided by 3 and the like are off their lattice by some 1e-5 px.
constexpr double kTolerance = 0.01;
constexpr double kEqual_px = kLeastQuantum_px * kTolerance;

double off_lattice(double difference, double quantum) {
    return std::abs(difference - std::nearbyint(difference / quantum) * quantum);
}

// Euclid's algorithm; values below kEqual_px count as 0.
double greatest_common_divisor(double a, double b) {
    while (b > kEqual_px) {
        const double rest = off_lattice(a, b);
        a = b;
        b = rest;
    }
    return a;
}

// The lattice of the differences seen so far.
struct Lattice {
    double quantum = 0;
    double farthest = 0;  // largest difference that `quantum` was refined by

    void add(double difference) {
        if (difference < kEqual_px) return;
        if (quantum == 0) {
            quantum = farthest = difference;
        } else if (const double off = off_lattice(difference, quantum); off > kTolerance * quantum) {
            const double before = quantum;
            quantum = greatest_common_divisor(before, off);
            farthest = 0;
            // From small to large, so that the quantum is exact enough to count the steps of the next.
            for (const double multiple : {off, before, difference}) make_exact(multiple);
        } else {
            make_exact(difference);
        }
    }

  private:
    void make_exact(double multiple) {
        if (multiple <= farthest) return;
        quantum = multiple / std::nearbyint(multiple / quantum);
        farthest = multiple;
    }
};

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
    void add(const Sizes& others) {
        for (std::size_t i = 0; i < bins.size(); ++i) bins[i] += others.bins[i];
        count += others.count;
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

double find_quantum_px(const DisparityMap& map) {
    const auto is_given = [&map](std::size_t i) {
        return DisparityMap::known(map.values[i]) &&
               (map.origins.empty() || map.origins[i] != PixelOrigin::filled);
    };
    std::size_t first = 0;
    while (first < map.values.size() && !is_given(first)) ++first;
    if (first == map.values.size()) return 0;
    Lattice lattice;
    float last = map.values[first];  // neighbours are often equal and need not be examined twice
    for (std::size_t i = first; i < map.values.size(); ++i) {
        if (map.values[i] == last || !is_given(i)) continue;
        last = map.values[i];
        lattice.add(std::abs(static_cast<double>(last) - map.values[first]));
        if (lattice.quantum > 0 && lattice.quantum < kLeastQuantum_px * (1 - kTolerance)) return 0;
    }
    return lattice.quantum <= kLargestQuantum_px * (1 + 1e-4) ? lattice.quantum : 0;
}

double find_noise_px(const DisparityMap& map, int threads) {
    const auto add = [&](Sizes& sizes, int x, int y, int dx, int dy) {
        double d[4];
        for (int k = 0; k < 4; ++k) {
            const std::size_t at = static_cast<std::size_t>(y + k * dy) * map.width + (x + k * dx);
            if (map.origins[at] != PixelOrigin::matched) return;
            d[k] = map.values[at];
        }
        sizes.add(std::abs(d[3] - 3 * d[2] + 3 * d[1] - d[0]));
    };
    constexpr int kReach_px = 3 * kStride_px;
    Sizes sizes;
    std::mutex adding;
    ThreadPool(threads).parallel_for(map.height, [&](std::size_t begin, std::size_t end) {
        Sizes of_band;
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < map.width; ++x) {
                if (x + kReach_px < map.width) add(of_band, x, y, kStride_px, 0);
                if (y + kReach_px < map.height) add(of_band, x, y, 0, kStride_px);
            }
        const std::lock_guard lock(adding);
        sizes.add(of_band);
    });
    if (sizes.count < kLeastCount) return 0;
    const double noise_px = sizes.median_px() / kMedianOfNoise;
    return noise_px > 0 ? noise_px : 0;
}

NoiseSmoothing smoothing_for(double noise_px, double least_px) {
    if (noise_px < least_px) return {};
    return {noise_px, 7 * noise_px};
}

}  // namespace hexrelief::stages
