#include "pipeline/checks/map_statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace hexrelief::checks {
namespace {

constexpr int kMapLines = 100;  // most rows or columns examined
// Runs of pixels whose values change by less than kLeastRange are ignored, and so are runs that leave more
// than kLargestRest of a line: they are no planes.
constexpr double kLeastRange = 0.08;   // share of the largest value
constexpr double kLargestRest = 0.04;  // share of the values' sum of squares
constexpr int kLeastRuns = 20;         // fewer tell nothing
constexpr double kTopmost = 0.03;      // share of the range of values
constexpr double kSmoothStep = 0.08;   // share of the range of values

// Returns the share of a run's sum of squares about its mean that a fitted line leaves.
double rest_of_line(const std::vector<double>& values) {
    const double count = static_cast<double>(values.size()), middle = 0.5 * (count - 1);
    double mean = 0, spread = 0, along = 0, squares = 0;
    for (const double v : values) mean += v / count;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double v = values[i] - mean, t = static_cast<double>(i) - middle;
        spread += v * v;
        along += v * t;
        squares += t * t;
    }
    return spread > 0 ? std::max(0.0, 1 - along * along / squares / spread) : 1;
}

struct Leaning {
    int runs = 0;
    double sum = 0;

    void judge(const std::vector<double>& values) {
        const auto [low, high] = std::minmax_element(values.begin(), values.end());
        if (*low <= 0 || *high - *low < kLeastRange * *high) return;
        std::vector<double> reciprocals;
        for (const double v : values) reciprocals.push_back(1 / v);
        const double as_it_is = rest_of_line(values), inverse = rest_of_line(reciprocals);
        if (std::min(as_it_is, inverse) > kLargestRest) return;
        ++runs;
        sum += (inverse - as_it_is) / (inverse + as_it_is + 1e-12);
    }
};

// Calls visit(x, y, along_x) for the first pixel of each line examined.
template <typename Visit>
void each_line(const DisparityMap& map, const Visit& visit) {
    for (int y = 0; y < map.height; y += std::max(1, map.height / kMapLines)) visit(0, y, true);
    for (int x = 0; x < map.width; x += std::max(1, map.width / kMapLines)) visit(x, 0, false);
}

void judge_line(const DisparityMap& map, int x, int y, bool along_x, int length, Leaning& leaning) {
    const int count = along_x ? map.width : map.height;
    std::vector<double> run;
    for (int i = 0; i < count; ++i) {
        const float d = along_x ? map.at(i, y) : map.at(x, i);
        if (DisparityMap::known(d))
            run.push_back(d);
        else
            run.clear();
        if (static_cast<int>(run.size()) < length) continue;
        leaning.judge(run);
        run.erase(run.begin(), run.begin() + length / 2);
    }
}

// A run of equal values, and the position of its first pixel on the line.
struct Plateau {
    float value;
    int position;
};
using Stretch = std::vector<Plateau>;  // smooth ground along a line

// Returns the number of pixels around plateau i that are not below `value`; 0 unless the stretch goes below
// it on both sides.
int length_above(const Stretch& stretch, std::size_t i, float value) {
    std::size_t first = i, end = i;
    while (first > 0 && stretch[first].value >= value) --first;
    while (end + 1 < stretch.size() && stretch[end].value >= value) ++end;
    const bool is_whole = stretch[first].value < value && stretch[end].value < value;
    return is_whole ? stretch[end].position - stretch[first + 1].position : 0;
}

struct TurnCounts {
    int all = 0, topmost = 0;
    int top_px = 0, slopes_px = 0;  // lengths of the first band below the top, and of the first four
};

// Counts the places where values rise at least twice and then fall at least twice.
void count_turns(const Stretch& stretch, float high, float band, TurnCounts& turns) {
    for (std::size_t i = 2; i + 2 < stretch.size(); ++i) {
        const Plateau* v = stretch.data() + i;
        const bool turns_here = v[-2].value < v[-1].value && v[-1].value < v[0].value &&
                                v[0].value > v[1].value && v[1].value > v[2].value;
        if (!turns_here) continue;
        ++turns.all;
        if (v->value < high - band) continue;
        ++turns.topmost;
        const int slopes_px = length_above(stretch, i, high - 4 * band);
        if (slopes_px == 0) continue;
        turns.top_px += length_above(stretch, i, high - band);
        turns.slopes_px += slopes_px;
    }
}

}  // namespace

MapValues measure_values(const DisparityMap& map) {
    struct Sample {
        float value;
        int y;
    };
    std::vector<Sample> samples;
    MapValues result;
    const int stride = std::max(1, map.width / kMapLines);
    for (int y = stride / 2; y < map.height; y += stride)
        for (int x = stride / 2; x < map.width; x += stride)
            if (const float d = map.at(x, y); DisparityMap::known(d)) {
                samples.push_back({d, y});
                result.are_bytes = result.are_bytes && d >= 0 && d <= 255 && d == std::floor(d);
            }
    if (samples.empty()) return result;
    std::stable_sort(samples.begin(), samples.end(),
                     [](const auto& a, const auto& b) { return a.value < b.value; });
    const double count = static_cast<double>(samples.size());
    double rank = 0, sums[5] = {};  // sums of rank, row, their squares and their product, about the middle
    for (std::size_t first = 0, i = 0; i < samples.size(); ++i) {
        if (samples[i].value != samples[first].value) first = i;
        if (first == i) {  // equal values share one rank, the mean of their ranks
            std::size_t last = i;
            while (last + 1 < samples.size() && samples[last + 1].value == samples[i].value) ++last;
            rank = 0.5 * static_cast<double>(first + last) - 0.5 * (count - 1);
        }
        const double row = samples[i].y - 0.5 * map.height;
        sums[0] += rank;
        sums[1] += row;
        sums[2] += rank * rank;
        sums[3] += row * row;
        sums[4] += rank * row;
    }
    const double variances = (count * sums[2] - sums[0] * sums[0]) * (count * sums[3] - sums[1] * sums[1]);
    result.count = static_cast<int>(samples.size());
    result.median_px = samples[samples.size() / 2].value;
    result.largest_px = samples[samples.size() - 1 - samples.size() / 100].value;
    if (variances > 0) result.row_correlation = (count * sums[4] - sums[0] * sums[1]) / std::sqrt(variances);
    return result;
}

bool are_greys(const DisparityMap& map, const MapScale& stored) {
    constexpr double kRounding = 1e-3;  // more than the rounding of a division of 255 by the scale
    return std::ranges::all_of(map.values, [&](float d) {
        const double sample = (d - stored.offset_px) * stored.scale;
        return !DisparityMap::known(d) || (sample > -kRounding && sample < 255 + kRounding &&
                                           std::fabs(sample - std::round(sample)) < kRounding);
    });
}

double measure_straightness(const DisparityMap& map) {
    const int length = std::max(12, map.width / 4);
    Leaning leaning;
    each_line(map, [&](int x, int y, bool along_x) { judge_line(map, x, y, along_x, length, leaning); });
    return leaning.runs >= kLeastRuns ? leaning.sum / leaning.runs : 0;
}

TurningPoints measure_turning(const DisparityMap& map) {
    const KnownRange range = known_range(map);
    TurnCounts turns;
    const float step = static_cast<float>(kSmoothStep) * (range.largest - range.least);
    const float band = static_cast<float>(kTopmost) * (range.largest - range.least);
    Stretch stretch;
    each_line(map, [&](int x, int y, bool along_x) {
        const auto end_stretch = [&] {
            count_turns(stretch, range.largest, band, turns);
            stretch.clear();
        };
        const int count = along_x ? map.width : map.height;
        for (int i = 0; i < count; ++i) {
            const float d = along_x ? map.at(i, y) : map.at(x, i);
            const bool known = DisparityMap::known(d);
            if (!stretch.empty() && (!known || std::fabs(d - stretch.back().value) > step)) end_stretch();
            if (known && (stretch.empty() || d != stretch.back().value)) stretch.push_back({d, i});
        }
        end_stretch();
    });
    return {turns.all, turns.topmost / std::max(1.0, static_cast<double>(turns.all)),
            turns.top_px / std::max(1.0, static_cast<double>(turns.slopes_px))};
}

}  // namespace hexrelief::checks
