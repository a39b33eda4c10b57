#include "pipeline/job/budget/budget.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pipeline/data/error.h"

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

// Below this quality a JPEG's blocks are visible, and fewer pixels look better.
constexpr int kLeastQuality = 50, kQualityStep = 10, kShrunkQuality = 70;
constexpr int kLeastSide_px = 32;

// Rough slopes on logarithmic scales, measured on Middlebury's maps: they give the first step of each search.
constexpr double kVertexSlope = -2, kByteSlope = -1.5, kErrorSlope = 0.8;
// Number of tolerances tried: the configured one, twice and four times it.
constexpr int kTolerances = 3;
constexpr double kTextureShare = 0.5;  // largest share of the bytes

std::string number(double value) {
    char text[64];
    std::snprintf(text, sizeof text, value == std::floor(value) ? "%.0f" : "%.3g", value);
    return text;
}

[[noreturn]] void out_of_reach(const std::string& key, double limit, const SpacingFound& nearest,
                               const std::string& what, const std::string& advice) {
    const std::string came = nearest.value > 0 ? "the nearest is " + number(nearest.value) + what +
                                                     " at a spacing of " + number(nearest.spacing_px) + " px"
                                               : std::string("no spacing leaves a mesh");
    throw Error(ErrorKind::usage, "budget." + key + " of " + number(limit) + what +
                                      " is out of reach: " + came + "; " + advice);
}

struct Search {
    const BudgetJob& job;
    int solves = 0;
    double last_spacing_px = 0, last_tolerance_px = 0;

    bool solve(double spacing_px, double tolerance_px) {
        last_spacing_px = spacing_px;
        last_tolerance_px = tolerance_px;
        ++solves;
        return job.solve(spacing_px, tolerance_px);
    }
    std::optional<SpacingFound> find(double limit, double slope, double start_px, double tolerance_px,
                                     const std::function<double()>& figure, SpacingFound& nearest) {
        return search_spacing(
            {limit, slope, start_px, job.least_px, job.most_px},
            [&](double spacing_px) -> std::optional<double> {
                if (!solve(spacing_px, tolerance_px)) return std::nullopt;
                return figure();
            },
            nearest);
    }
    void settle(double spacing_px, double tolerance_px) {
        if (spacing_px != last_spacing_px || tolerance_px != last_tolerance_px)
            solve(spacing_px, tolerance_px);
    }
};

// Returns the best mesh for the texture in use.
std::optional<BudgetResult> fit_mesh_bytes(double limit, Search& search, SpacingFound& nearest) {
    const BudgetJob& job = search.job;
    std::optional<BudgetResult> best;
    double least_error_px = 0, start_px = job.start_px;
    for (int i = 0; i < (job.compressed ? kTolerances : 1); ++i) {
        const double tolerance_px = job.tolerance_px * (1 << i);
        const auto found = search.find(limit, kByteSlope, start_px, tolerance_px, job.bytes, nearest);
        if (!found) continue;  // a coarser tolerance may still succeed
        search.settle(found->spacing_px, tolerance_px);
        const double error_px = job.error_px();
        if (best && error_px >= least_error_px) break;
        least_error_px = error_px;
        start_px = found->spacing_px;
        best = BudgetResult{"max_bytes", limit, found->value, found->spacing_px, tolerance_px, 0, {}};
    }
    return best;
}

BudgetResult fit_bytes(double limit, Search& search) {
    const BudgetJob& job = search.job;
    SpacingFound nearest;
    std::optional<BudgetResult> best;
    if (job.texture && search.solve(job.start_px, job.tolerance_px)) {
        // A share of 0 gives the smallest texture of all.
        for (const double share : {kTextureShare, kTextureShare / 2, 0.0}) {
            const TextureChoice chosen = choose_texture(*job.texture, limit, share, job.texture_bytes);
            job.use_texture(chosen);
            best = fit_mesh_bytes(limit, search, nearest);
            if (!best) continue;
            best->texture = chosen;
            break;
        }
    } else {
        best = fit_mesh_bytes(limit, search, nearest);
    }
    if (!best)
        out_of_reach("max_bytes", limit, nearest, " bytes",
                     "the mesh's spacing and the texture do not shrink any further: see export.texture, "
                     "export.normals");
    return *best;
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

std::vector<TextureChoice> texture_choices(const TextureLimits& limits) {
    const auto [max_px, quality] = limits.configured;
    std::vector<TextureChoice> choices{limits.configured};
    const bool falls = limits.may_lose_quality && quality > kLeastQuality;
    if (falls)
        for (int lower = (quality - 1) / kQualityStep * kQualityStep; lower >= kLeastQuality;
             lower -= kQualityStep)
            choices.push_back({max_px, lower});
    if (!limits.may_shrink) return choices;
    for (int step = 1;; ++step) {
        const int side = static_cast<int>(std::lround(limits.longest_px * std::pow(0.5, 0.5 * step)));
        if (side < kLeastSide_px) return choices;
        choices.push_back({side, falls ? std::min(quality, kShrunkQuality) : quality});
        if (falls) choices.push_back({side, kLeastQuality});
    }
}

TextureChoice choose_texture(const TextureLimits& limits, double max_bytes, double share,
                             const std::function<double(const TextureChoice&)>& bytes) {
    const std::vector<TextureChoice> choices = texture_choices(limits);
    const auto first = std::partition_point(choices.begin(), choices.end(), [&](const TextureChoice& choice) {
        return bytes(choice) > share * max_bytes;
    });
    return first == choices.end() ? choices.back() : *first;
}

bool has_budget(const config::BudgetConfig& budget) {
    return budget.vertices > 0 || budget.max_bytes > 0 || budget.max_error_px > 0;
}

BudgetResult fit_budget(const config::BudgetConfig& budget, const BudgetJob& job) {
    Search search{job};
    SpacingFound nearest;
    BudgetResult result;
    const auto fit = [&](const char* kind, double limit, double slope, const std::function<double()>& figure,
                         const char* what, const char* advice) {
        const auto found = search.find(limit, slope, job.start_px, job.tolerance_px, figure, nearest);
        if (!found) out_of_reach(kind, limit, nearest, what, advice);
        result = {kind, limit, found->value, found->spacing_px, job.tolerance_px, 0, {}};
    };
    if (budget.vertices > 0)
        fit("vertices", double(budget.vertices), kVertexSlope, job.vertices, " vertices",
            "give more, or raise the background's threshold");
    else if (budget.max_error_px > 0)
        fit("max_error_px", budget.max_error_px, kErrorSlope, job.error_px, " px",
            "give more; export.tolerance_px and unknown pixels limit it as well");
    else if (budget.max_bytes > 0)
        result = fit_bytes(double(budget.max_bytes), search);
    else
        return result;
    search.settle(result.spacing_px, result.tolerance_px);
    result.solves = search.solves;
    return result;
}

}  // namespace hexrelief::job
