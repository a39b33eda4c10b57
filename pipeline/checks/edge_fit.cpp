#include "pipeline/checks/edge_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "pipeline/checks/thresholds.h"

namespace hexrelief::checks {
namespace {

constexpr int kEdgeLines = 120;      // most rows or columns examined
constexpr double kLeastStep = 0.08;  // as a share of the range of values
constexpr int kNear_px = 2;          // offsets that count as here
// Things may be larger in the map than in the picture by this, or smaller, on each side.
constexpr int kMostLarger_px = 6, kMostSmaller_px = 2;
constexpr int kElsewhere = 32;  // places that the picture is moved to, for comparison

double least_step(const DisparityMap& map) {
    std::vector<float> known = known_values(map, std::max<std::size_t>(1, map.values.size() / 40000));
    if (known.empty()) return 0;
    std::sort(known.begin(), known.end());
    return kLeastStep * (known[known.size() * 19 / 20] - known[known.size() / 20]);
}

// The rows or columns of a map and a picture that are examined.
struct Lines {
    const DisparityMap& map;
    const Image& picture;
    bool along_x;
    int count, length, stride;

    Lines(const DisparityMap& of, const Image& left, bool rows) : map(of), picture(left), along_x(rows) {
        const int all = rows ? of.height : of.width;
        length = rows ? of.width : of.height;
        stride = std::max(1, all / kEdgeLines);
        count = (all - stride / 2 + stride - 1) / stride;
    }

    int across(int line) const { return stride / 2 + line * stride; }
    float value(int line, int at) const {
        return along_x ? map.at(at, across(line)) : map.at(across(line), at);
    }
    const std::uint8_t* pixel(int line, int at) const {
        return along_x ? picture.at(at, across(line)) : picture.at(across(line), at);
    }
};

// A depth discontinuity between the pixels `at` and at + 1 of a line.
struct Step {
    int line, at;
    bool rises;  // the larger disparity follows
};

// Finds the places on a line at which disparities differ most over 2 * half pixels, if by `least` or more.
void find_steps(const Lines& lines, int line, int half, double least, std::vector<Step>& steps) {
    std::vector<double> rise(static_cast<std::size_t>(lines.length), 0.0);
    for (int at = half - 1; at + half < lines.length; ++at) {
        const float before = lines.value(line, at + 1 - half), after = lines.value(line, at + half);
        if (DisparityMap::known(before) && DisparityMap::known(after) &&
            DisparityMap::known(lines.value(line, at)) && DisparityMap::known(lines.value(line, at + 1)))
            rise[static_cast<std::size_t>(at)] = static_cast<double>(after) - before;
    }
    for (int first = 0; first < lines.length; ++first) {
        const double value = rise[static_cast<std::size_t>(first)];
        if (std::fabs(value) < least) continue;
        int last = first;  // of equal differences, the middle
        while (last + 1 < lines.length && rise[static_cast<std::size_t>(last) + 1] == value) ++last;
        const int from = std::max(0, first - half), to = std::min(lines.length - 1, last + half);
        const bool is_largest = std::all_of(rise.begin() + from, rise.begin() + to + 1, [&](double other) {
            return std::fabs(other) <= std::fabs(value);
        });
        if (is_largest) steps.push_back({line, (first + last) / 2, value > 0});
        first = last;
    }
}

// The picture's contrasts along the lines, as ranks from 0 to 1: of the mean colours of `half` pixels on both
// sides of each pair of neighbours.
class Contrasts {
  public:
    Contrasts(const Lines& lines, int half) : length_(lines.length), lines_(lines.count) {
        levels_.resize(static_cast<std::size_t>(lines_) * length_);
        for (int line = 0; line < lines_; ++line) measure(lines, line, half);
        std::array<double, 256> counts{};
        for (const std::uint8_t level : levels_) ++counts[level];
        double below = 0;
        for (std::size_t i = 0; i < counts.size(); ++i) {
            ranks_[i] = (below + 0.5 * counts[i]) / static_cast<double>(levels_.size());
            below += counts[i];
        }
    }

    // at: from -length() to 2 * length(); line: from 0 to 2 * lines(). The picture repeats itself.
    double rank(int line, int at) const {
        const int l = line >= lines_ ? line - lines_ : line;
        const int i = at < 0 ? at + length_ : at >= length_ ? at - length_ : at;
        return ranks_[levels_[static_cast<std::size_t>(l) * length_ + i]];
    }
    int length() const { return length_; }
    int lines() const { return lines_; }

  private:
    void measure(const Lines& lines, int line, int half) {
        const int channels = lines.picture.channels;
        for (int c = 0; c < channels; ++c) {
            std::vector<int> sums{0};  // of the first pixels
            for (int at = 0; at < length_; ++at) sums.push_back(sums.back() + lines.pixel(line, at)[c]);
            for (int at = half - 1; at + half < length_; ++at) {
                const auto i = static_cast<std::size_t>(at + 1), k = static_cast<std::size_t>(half);
                const int level = std::abs((sums[i + k] - sums[i]) - (sums[i] - sums[i - k])) / half;
                std::uint8_t& most = levels_[static_cast<std::size_t>(line) * length_ + at];
                most = std::max(most, static_cast<std::uint8_t>(level));
            }
        }
    }

    int length_, lines_;
    std::vector<std::uint8_t> levels_;
    std::array<double, 256> ranks_{};
};

// The mean contrasts at each offset from the steps, up to `reach`, of those that rise and those that fall.
struct Profile {
    int reach;
    std::vector<double> rising, falling;  // weighted by their share of all steps

    Profile(const std::vector<Step>& steps, const Contrasts& contrasts, int reach_px, int lines_on, int px_on)
        : reach(reach_px + 1), rising(static_cast<std::size_t>(2 * reach + 1)), falling(rising.size()) {
        for (const Step& step : steps) {
            std::vector<double>& sums = step.rises ? rising : falling;
            for (int offset = -reach; offset <= reach; ++offset)
                sums[static_cast<std::size_t>(offset + reach)] +=
                    contrasts.rank(step.line + lines_on, (step.at + px_on) % contrasts.length() + offset) /
                    static_cast<double>(steps.size());
        }
    }

    static double smoothed(const std::vector<double>& values, int index) {
        const auto i = static_cast<std::size_t>(index);
        return 0.25 * values[i - 1] + 0.5 * values[i] + 0.25 * values[i + 1];
    }

    // Returns the contrast at an offset, for the best size of the map's things.
    double at(int offset) const {
        double best = 0;
        for (int larger = -kMostSmaller_px; larger <= kMostLarger_px; ++larger)
            best = std::max(
                best, smoothed(rising, offset + larger + reach) + smoothed(falling, offset - larger + reach));
        return best;
    }

    double near_by() const {
        double best = 0;
        for (int offset = -kNear_px; offset <= kNear_px; ++offset) best = std::max(best, at(offset));
        return best;
    }
};

struct Spread {
    double mean = 0, deviation = 0;
};

// Returns the fits elsewhere: the picture is moved along and across the lines by fractions that lie evenly.
Spread fits_elsewhere(const std::vector<Step>& steps, const Contrasts& contrasts) {
    constexpr double kAlong = 0.6180339887498949, kAcross = 0.7548776662466927;
    double sum = 0, squares = 0;
    for (int k = 1; k <= kElsewhere; ++k) {
        const double along = 0.1 + 0.8 * (k * kAlong - std::floor(k * kAlong)),
                     across = k * kAcross - std::floor(k * kAcross);
        const double fit =
            Profile(steps, contrasts, kNear_px + kMostLarger_px, static_cast<int>(across * contrasts.lines()),
                    static_cast<int>(along * contrasts.length()))
                .near_by();
        sum += fit;
        squares += fit * fit;
    }
    const double mean = sum / kElsewhere;
    return {mean, std::sqrt(std::max(1e-12, squares / kElsewhere - mean * mean))};
}

AxisFit fit_axis(const Lines& lines, double step) {
    AxisFit fit;
    const int half = std::clamp(lines.map.width / 150, 3, 8), reach = std::max(16, lines.map.width / 40);
    if (lines.length < 4 * (reach + kMostLarger_px)) return fit;
    std::vector<Step> steps;
    for (int line = 0; line < lines.count; ++line) find_steps(lines, line, half, step, steps);
    fit.steps = static_cast<int>(steps.size());
    if (steps.empty()) return fit;
    const Contrasts contrasts(lines, half);
    const Spread elsewhere = fits_elsewhere(steps, contrasts);
    const Profile profile(steps, contrasts, reach + kMostLarger_px, 0, 0);
    const auto deviations = [&](double value) { return (value - elsewhere.mean) / elsewhere.deviation; };
    fit.here = deviations(profile.near_by());
    for (int offset = -reach; offset <= reach; ++offset)
        if (const double value = deviations(profile.at(offset)); value > fit.best) {
            fit.best = value;
            fit.best_px = offset;
        }
    return fit;
}

}  // namespace

EdgeFit measure_edge_fit(const DisparityMap& map, const Image& left) {
    const double step = least_step(map);
    if (!(step > 0)) return {};
    return {fit_axis({map, left, true}, step), fit_axis({map, left, false}, step)};
}

std::optional<double> fit_of(const EdgeFit& fit) {
    double sum = 0, axes = 0;
    for (const AxisFit& axis : {fit.columns, fit.rows})
        if (axis.steps >= kLeastSteps) {
            sum += axis.here;
            ++axes;
        }
    return axes > 0 ? std::optional(sum / std::sqrt(axes)) : std::nullopt;
}

}  // namespace hexrelief::checks
