#include "pipeline/stages/dequantize/noise.h"

#include <array>
#include <mutex>

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

constexpr int kMeanRadius_px = 7, kWindowRadius_px = 3;
constexpr float kMostMove_px = 1;  // the levels are linear no farther
constexpr float kLeastMiss = 1;    // levels; pictures are in whole ones
// A pixel whose levels differ by this many standard deviations has a quarter of its certainty.
constexpr float kDoubtful = 3;
constexpr float kDeviationOfMedian = 1.4826f;

Plane grey_of(const Image& image, ThreadPool& pool) {
    Plane grey(image.width, image.height);
    pool.parallel_for_each(image.height, [&](int y) {
        for (int x = 0; x < image.width; ++x) {
            const std::uint8_t* const c = image.at(x, y);
            grey.row(y)[x] = image.channels < 3 ? c[0] : 0.25f * static_cast<float>(c[0] + 2 * c[1] + c[2]);
        }
    });
    return grey;
}

// Returns the sums over squares; beyond the border the nearest pixel counts.
Plane box_sums(const Plane& plane, int radius, ThreadPool& pool) {
    Plane across(plane.width, plane.height), sums(plane.width, plane.height);
    const int last = plane.width - 1;
    pool.parallel_for_each(plane.height, [&](int y) {
        const float* const in = plane.row(y);
        float* const out = across.row(y);
        double sum = 0;
        for (int i = -radius; i <= radius; ++i) sum += in[std::clamp(i, 0, last)];
        for (int x = 0; x < plane.width; ++x) {
            out[x] = static_cast<float>(sum);
            sum += static_cast<double>(in[std::min(x + radius + 1, last)]) - in[std::max(x - radius, 0)];
        }
    });
    pool.parallel_for_each(plane.height, [&](int y) {
        float* const out = sums.row(y);
        for (int j = -radius; j <= radius; ++j) {
            const float* const in = across.row(std::clamp(y + j, 0, plane.height - 1));
            for (int x = 0; x < plane.width; ++x) out[x] += in[x];
        }
    });
    return sums;
}

void subtract_means(Plane& plane, ThreadPool& pool) {
    constexpr float kShare = 1.f / ((2 * kMeanRadius_px + 1) * (2 * kMeanRadius_px + 1));
    const Plane sums = box_sums(plane, kMeanRadius_px, pool);
    for (std::size_t i = 0; i < plane.values.size(); ++i) plane.values[i] -= kShare * sums.values[i];
}

// Interpolates by the cubic of Catmull and Rom. width >= 4.
float level_at(const float* row, int width, float x) {
    const int at = std::clamp(static_cast<int>(std::floor(x)), 1, width - 3);
    const float t = x - static_cast<float>(at);
    const float p0 = row[at - 1], p1 = row[at], p2 = row[at + 1], p3 = row[at + 2];
    return p1 + 0.5f * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

// Returns the slopes along x of both pictures' mean, by Sobel's operator.
Plane slopes_of(const Plane& left, const Plane& right, ThreadPool& pool) {
    Plane slopes(left.width, left.height);
    const int last_x = left.width - 1, last_y = left.height - 1;
    pool.parallel_for_each(left.height, [&](int y) {
        for (int x = 0; x <= last_x; ++x) {
            const auto rise = [&](int v) {
                v = std::clamp(v, 0, last_y);
                const int before = std::max(x - 1, 0), behind = std::min(x + 1, last_x);
                return (left.row(v)[behind] - left.row(v)[before]) +
                       (right.row(v)[behind] - right.row(v)[before]);
            };
            slopes.row(y)[x] = 0.0625f * (rise(y - 1) + 2 * rise(y) + rise(y + 1));
        }
    });
    return slopes;
}

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

PairLevels::PairLevels(const StereoPair& pair, ThreadPool& pool)
    : left_(grey_of(pair.left, pool)), right_(grey_of(pair.right, pool)), left_detail_(left_) {
    subtract_means(left_detail_, pool);
}

Evidence PairLevels::evidence_for(const DisparityMap& map, ThreadPool& pool) const {
    const int width = map.width, height = map.height;
    std::vector<std::uint8_t> is_seen(map.values.size());
    Plane seen = left_;  // what the right picture shows of each pixel
    pool.parallel_for_each(height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            if (map.origins[i] != PixelOrigin::matched) continue;
            const float at = static_cast<float>(x) - map.values[i];
            if (!(at >= 1 && at <= static_cast<float>(width - 2))) continue;
            is_seen[i] = 1;
            seen.row(y)[x] = level_at(right_.row(y), width, at);
        }
    });
    subtract_means(seen, pool);
    const Plane slopes = slopes_of(left_detail_, seen, pool);

    const auto size_at = [&](std::size_t i) { return is_seen[i] ? std::abs(slopes.values[i]) : -1; };
    const float steep = median_of(is_seen.size(), pool, size_at);
    const auto miss_at = [&](std::size_t i) {
        return size_at(i) >= steep ? std::abs(seen.values[i] - left_detail_.values[i]) : -1;
    };
    const float miss = std::max(kLeastMiss, kDeviationOfMedian * median_of(is_seen.size(), pool, miss_at));

    Evidence evidence{Plane(width, height), Plane(width, height), Plane(0, 0), miss};
    pool.parallel_for_each(height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            if (!is_seen[i]) continue;
            const float slope = slopes.values[i], off = seen.values[i] - left_detail_.values[i];
            const float doubt = 1 + off * off / (kDoubtful * kDoubtful * miss * miss);
            constexpr float kFlat = 1e-3f;  // keeps the quotient finite
            evidence.certainty.row(y)[x] = slope * slope / (miss * miss * doubt * doubt);
            evidence.target.row(y)[x] = map.values[i] + std::clamp(slope * off / (slope * slope + kFlat),
                                                                   -kMostMove_px, kMostMove_px);
        }
    });
    evidence.around = box_sums(evidence.certainty, kWindowRadius_px, pool);
    return evidence;
}

}  // namespace hexrelief::stages
