#include "pipeline/job/budget/spacing_search.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::job {
namespace {

constexpr int kMostSolves = 12;
constexpr double kNearLimit = 0.97;  // share of the limit that is near enough
constexpr double kBracket = 1.01;    // ratio of two spacings that is near enough
constexpr double kLargestStep = 4;   // largest ratio of a spacing to the last one

struct Tried {
    double spacing_px;
    double value;
};

double hundredths(double spacing_px) {
    return std::round(spacing_px * 100) / 100;
}

// Returns the spacing at which the line through two points, on logarithmic scales, meets the limit. It stays
// away from both points: the figure is not a straight line, and the search could otherwise move only one of
// them, in ever smaller steps.
double between(const Tried& a, const Tried& b, double limit) {
    double share = 0.5;
    const double from = std::log(a.value), to = std::log(b.value);
    if (from != to) share = std::clamp((std::log(limit) - from) / (to - from), 0.1, 0.9);
    return a.spacing_px * std::pow(b.spacing_px / a.spacing_px, share);
}

}  // namespace

std::optional<SpacingFound> search_spacing(const SpacingSearch& search, const SpacingFigure& figure,
                                           SpacingFound& nearest) {
    const bool falls = search.slope < 0;
    double most_px = std::floor(search.most_px * 100) / 100;  // rounding up could pass it
    std::optional<Tried> kept, broken;  // the best that keeps the limit, and the nearest to it that does not
    double spacing_px = hundredths(std::clamp(search.start_px, search.least_px, most_px));
    nearest = {};
    int solves = 0;
    double least_step = 1.02;
    while (solves < kMostSolves) {
        const std::optional<double> value = figure(spacing_px);
        ++solves;
        if (!value) {  // too coarse for any mesh
            most_px = spacing_px;
            const double finer = kept && !falls ? kept->spacing_px
                                 : broken       ? broken->spacing_px
                                                : search.least_px;
            if (most_px / finer < kBracket) break;
            spacing_px = hundredths(std::sqrt(most_px * finer));
            continue;
        }
        const Tried here{spacing_px, *value};
        if (*value <= search.limit) {
            const bool better =
                !kept || (falls ? spacing_px < kept->spacing_px : spacing_px > kept->spacing_px);
            if (better) kept = here;
            if (*value >= kNearLimit * search.limit) break;
        } else {
            const bool closer =
                !broken || (falls ? spacing_px > broken->spacing_px : spacing_px < broken->spacing_px);
            if (closer) broken = here;
            if (nearest.solves == 0 || *value < nearest.value) nearest = {spacing_px, *value, solves};
        }
        double next = 0;
        if (kept && broken) {
            if (std::max(kept->spacing_px, broken->spacing_px) <
                kBracket * std::min(kept->spacing_px, broken->spacing_px))
                break;
            next = between(*kept, *broken, search.limit);
        } else {
            // A little past the limit, so that the next spacing brackets it; farther each time, because part
            // of the figure may not change with the spacing.
            const bool coarser = (*value > search.limit) == falls;
            const double step =
                std::pow(std::max(search.limit / *value, *value / search.limit), 1 / std::fabs(search.slope));
            least_step = std::min(kLargestStep, least_step * least_step);
            const double ratio = std::clamp(step * 1.02, least_step, kLargestStep);
            next = coarser ? spacing_px * ratio : spacing_px / ratio;
        }
        next = hundredths(std::clamp(next, search.least_px, most_px));
        const auto same = [&](const std::optional<Tried>& other) {
            return other && other->spacing_px == next;
        };
        if (next == spacing_px || same(kept) || same(broken)) break;
        spacing_px = next;
    }
    nearest.solves = solves;
    if (!kept) return std::nullopt;
    return SpacingFound{kept->spacing_px, kept->value, solves};
}

}  // namespace hexrelief::job
