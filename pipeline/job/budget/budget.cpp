#include "pipeline/job/budget/budget.h"

#include <cmath>
#include <cstdio>
#include <optional>

#include "pipeline/data/error.h"
#include "pipeline/job/budget/spacing_search.h"

namespace hexrelief::job {
namespace {

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
