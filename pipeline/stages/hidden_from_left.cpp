#include "pipeline/stages/hidden_from_left.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {
namespace {

constexpr double kJoined_px = 1;  // neighbours whose disparities differ by more belong to two surfaces
constexpr int kLeastGap_px = 2;   // narrower gaps come from rounding

bool known(float d) {
    return DisparityMap::known(d) && d > 0;
}

// Warps one row to the right view: `seen` gets the nearest disparity at each pixel, 0 where nothing arrives.
void carry_over(const float* left, int width, std::vector<float>& seen) {
    std::fill(seen.begin(), seen.end(), 0.0f);
    const auto put = [&](long column, double d) {
        if (column >= 0 && column < width) seen[column] = std::max(seen[column], static_cast<float>(d));
    };
    for (int x = 0; x < width; ++x) {
        if (!known(left[x])) continue;
        const double d = left[x], at = x - d;
        put(std::lround(at), d);
        if (x + 1 == width || !known(left[x + 1])) continue;
        const double next_d = left[x + 1], next = x + 1 - next_d;
        if (std::fabs(next_d - d) > kJoined_px) continue;
        for (long column = static_cast<long>(std::ceil(at)); column <= std::floor(next); ++column)
            put(column, next > at ? d + (column - at) / (next - at) * (next_d - d) : d);
    }
}

// True if the left map knows all pixels between the two silhouettes that bound the gap first .. last
// of the right view.
bool known_between_silhouettes(const float* left, int width, const std::vector<float>& seen, int first,
                               int last) {
    const long from = std::max(0L, std::lround(first - 1 + static_cast<double>(seen[first - 1])));
    const long to = std::min<long>(width - 1, std::lround(last + 1 + static_cast<double>(seen[last + 1])));
    for (long x = from; x <= to; ++x)
        if (!known(left[x])) return false;
    return true;
}

void find_gaps(const float* left, int width, const std::vector<float>& seen, float* hidden) {
    for (int first = 1; first < width; ++first) {
        if (seen[first] > 0 || !(seen[first - 1] > 0)) continue;
        int last = first;
        while (last + 1 < width && !(seen[last + 1] > 0)) ++last;
        if (last + 1 == width) return;
        if (last - first + 1 < kLeastGap_px || !known_between_silhouettes(left, width, seen, first, last))
            continue;
        const float d = std::min(seen[first - 1], seen[last + 1]);
        for (int x = first; x <= last; ++x) {
            const long origin = std::lround(x + static_cast<double>(d));
            if (origin >= 0 && origin < width) hidden[x] = d;
        }
    }
}

}  // namespace

std::vector<float> hidden_from_left(const DisparityMap& left, int threads) {
    std::vector<float> hidden(left.values.size(), 0.0f);
    for_row_bands(left.height, threads, [&](int begin, int end) {
        std::vector<float> seen(left.width);
        for (int y = begin; y < end; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * left.width;
            carry_over(&left.values[row], left.width, seen);
            find_gaps(&left.values[row], left.width, seen, &hidden[row]);
        }
    });
    return hidden;
}

}  // namespace hexrelief::stages
