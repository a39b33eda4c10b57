#include "pipeline/checks/edge_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace hexrelief::checks {
namespace {

constexpr int kEdgeLines = 200;      // most rows or columns examined
constexpr double kLeastStep = 0.08;  // as a share of the range of values
constexpr int kMostContrast = 48;    // grey levels: a few strong edges must not outweigh all others
constexpr int kBeside_px = 4;        // from this offset on the contrast counts as elsewhere

double least_step(const DisparityMap& map) {
    std::vector<float> known;
    const std::size_t stride = std::max<std::size_t>(1, map.values.size() / 40000);
    for (std::size_t i = 0; i < map.values.size(); i += stride)
        if (DisparityMap::known(map.values[i])) known.push_back(map.values[i]);
    if (known.empty()) return 0;
    std::sort(known.begin(), known.end());
    return kLeastStep * (known[known.size() * 19 / 20] - known[known.size() / 20]);
}

int contrast(const Image& image, int x, int y, int dx, int dy) {
    const std::uint8_t *a = image.at(x, y), *b = image.at(x + dx, y + dy);
    int most = 0;
    for (int c = 0; c < image.channels; ++c) most = std::max(most, std::abs(a[c] - b[c]));
    return std::min(most, kMostContrast);
}

// The sums of the contrast at each offset from a step.
struct Profile {
    explicit Profile(int reach_px)
        : reach(reach_px), sums(static_cast<std::size_t>(2 * reach_px + 1)), counts(sums.size()) {}

    double mean(int from, int to) const {
        double sum = 0;
        long long count = 0;
        for (int offset = from; offset <= to; ++offset) {
            sum += static_cast<double>(sums[static_cast<std::size_t>(offset + reach)]);
            count += counts[static_cast<std::size_t>(offset + reach)];
        }
        return count > 0 ? sum / static_cast<double>(count) : 0;
    }

    int reach;
    std::vector<long long> sums, counts;
};

AxisFit fit_of(const Profile& profile, int steps) {
    AxisFit fit;
    fit.steps = steps;
    const double all = profile.mean(-profile.reach, profile.reach);
    if (!(all > 0)) return fit;
    double sum = 0, squares = 0, count = 0, highest = 0;
    for (int offset = -profile.reach; offset <= profile.reach; ++offset) {
        const double value = profile.mean(offset, offset) / all;
        if (std::abs(offset) <= 1) highest = std::max(highest, value);
        if (std::abs(offset) < kBeside_px) continue;
        sum += value;
        squares += value * value;
        count += 1;
    }
    const double deviation = std::sqrt(std::max(1e-12, squares / count - sum * sum / count / count));
    fit.farthest = (highest - sum / count) / deviation;
    for (int offset = 1 - profile.reach; offset < profile.reach; ++offset) {
        const double value = profile.mean(offset - 1, offset + 1) / all;
        if (std::abs(offset) <= 1) fit.here = std::max(fit.here, value);
        if (value <= fit.best) continue;
        fit.best = value;
        fit.best_px = offset;
    }
    return fit;
}

AxisFit fit_axis(const DisparityMap& map, const Image& left, int dx, int dy, double step) {
    const int lines = dx ? map.height : map.width, length = dx ? map.width : map.height;
    const int stride = std::max(1, lines / kEdgeLines);
    Profile profile(std::max(16, map.width / 40));
    int steps = 0;
    for (int line = stride / 2; line < lines; line += stride)
        for (int i = 0; i + 1 < length; ++i) {
            const int x = dx ? i : line, y = dx ? line : i;
            const float a = map.at(x, y), b = map.at(x + dx, y + dy);
            if (!DisparityMap::known(a) || !DisparityMap::known(b) || std::fabs(a - b) < step) continue;
            ++steps;
            const int from = std::max(0, i - profile.reach), to = std::min(length - 2, i + profile.reach);
            for (int at = from; at <= to; ++at) {
                const std::size_t k = static_cast<std::size_t>(at - i + profile.reach);
                profile.sums[k] += contrast(left, dx ? at : line, dx ? line : at, dx, dy);
                ++profile.counts[k];
            }
        }
    return fit_of(profile, steps);
}

}  // namespace

EdgeFit measure_edge_fit(const DisparityMap& map, const Image& left) {
    const double step = least_step(map);
    if (!(step > 0)) return {};
    return {fit_axis(map, left, 1, 0, step), fit_axis(map, left, 0, 1, step)};
}

}  // namespace hexrelief::checks
