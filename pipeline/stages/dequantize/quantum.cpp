#include "pipeline/stages/dequantize/quantum.h"

#include <algorithm>
#include <cmath>

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

}  // namespace hexrelief::stages
