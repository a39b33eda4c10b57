#include "pipeline/alignment/estimate.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hexrelief::alignment {
namespace {

constexpr double kKnownWidth_px = 3;  // of the weights, from a start that is near
constexpr double kFocalDeviation = 0.2, kRadialDeviation = 0.06;
constexpr double kRadialGain = 0.92;       // of the cost of matches that were not fitted
constexpr double kQuarterTurnCost = 0.02;  // added to the row cost of pictures that have to be turned
constexpr std::size_t kMostInStarts = 400, kMostFitted = 1000;  // more matches cost time and tell little
constexpr std::size_t kLeastLikeNeighbours = 40;
// Views whose matches lie behind infinity by more than this are exchanged.
constexpr double kClearlyBehind_px = 3, kYawDeviations = 2;

Prior prior_of(const EstimateConfig& config, bool has_radial) {
    Prior prior;
    Parameters& d = prior.deviations;
    d[kPitch] = d[kYaw] = (config.is_rig ? 3 : 15) * kDegree;
    d[kRoll] = d[kCommonYaw] = d[kCommonRoll] = (config.is_rig ? 2 : 10) * kDegree;
    d[kFocalRatio] = config.is_rig ? 0.01 : 0.02;
    d[kFocal] = config.is_focal_known ? 0 : kFocalDeviation;
    d[kRadial] = has_radial ? kRadialDeviation : 0;
    return prior;
}

// Returns every `step`-th match from `first` on.
std::vector<Match> every(const std::vector<Match>& matches, std::size_t first, std::size_t step) {
    std::vector<Match> some;
    for (std::size_t i = first; i < matches.size(); i += step) some.push_back(matches[i]);
    return some;
}

// Returns so many of the matches, evenly.
std::vector<Match> at_most(const std::vector<Match>& matches, std::size_t most) {
    return every(matches, 0, std::max<std::size_t>(1, (matches.size() + most - 1) / most));
}

// Returns the matches that shift like those around them; all if these are few. Others are of repeated
// patterns, along the rows of which a wrong estimate may find more that agree than the true one does.
std::vector<Match> supported(const std::vector<Match>& matches) {
    std::vector<Point> shifts;
    for (const Match& match : matches)
        shifts.push_back({match.right.x - match.left.x, match.right.y - match.left.y});
    std::vector<std::size_t> places = supported_by_neighbours(matches, shifts);
    if (places.size() < kLeastLikeNeighbours) return matches;
    std::sort(places.begin(), places.end());
    std::vector<Match> some;
    for (const std::size_t i : places) some.push_back(matches[i]);
    return some;
}

Point turned(const Point& p, const Camera& camera) {
    return {p.y, camera.width - 1 - p.x};
}

std::vector<Match> turned(std::vector<Match> matches, const Camera& camera) {
    for (Match& match : matches) match = {turned(match.left, camera), turned(match.right, camera)};
    return matches;
}

std::vector<double> offsets_of(const Views& views, const std::vector<Match>& matches) {
    std::vector<double> offsets;
    for (const Match& match : matches) offsets.push_back(views.row_offset(match));
    return offsets;
}

// Finds orientation and parameters by the start with the least cost; of equal ones the first.
void find_start(Estimate& estimate, const EstimateConfig& config, ThreadPool& pool) {
    struct Orientation {
        bool is_turned;
        Camera camera;
        std::vector<Match> all, some;
    };
    const Camera& given = estimate.camera;
    std::vector<Orientation> orientations{{false, given, supported(estimate.matches), {}}};
    if (!config.is_rig)
        orientations.push_back(
            {true, {given.height, given.width, given.focal_px}, turned(orientations[0].all, given), {}});
    struct Attempt {
        const Orientation& orientation;
        Parameters start;
        Fit fit = {};
        double cost = 0;
    };
    std::vector<Attempt> attempts;
    for (Orientation& orientation : orientations) {
        orientation.some = at_most(orientation.all, kMostInStarts);
        std::vector<Parameters> starts = starts_of(orientation.camera, orientation.some);
        if (config.is_rig) starts.resize(1);
        for (const Parameters& start : starts) attempts.push_back({orientation, start});
    }
    // The focal length is held: far from the solution it would only be bent to what turns explain.
    const Prior prior = prior_of({true, config.is_rig}, false);
    pool.parallel_for_each(attempts.size(), [&](std::size_t i) {
        Attempt& attempt = attempts[i];
        const auto& [is_turned, camera, all, some] = attempt.orientation;
        attempt.fit = fit_views(camera, some, prior, attempt.start);
        attempt.cost =
            row_cost(views_of(camera, attempt.fit.parameters), all) + (is_turned ? kQuarterTurnCost : 0);
    });
    const Attempt& best = *std::min_element(
        attempts.begin(), attempts.end(), [](const Attempt& a, const Attempt& b) { return a.cost < b.cost; });
    estimate.is_quarter_turned = best.orientation.is_turned;
    if (best.orientation.is_turned) estimate.matches = turned(std::move(estimate.matches), given);
    estimate.camera = best.orientation.camera;
    estimate.fit = best.fit;
}

// True if the pictures' matches lie behind infinity by more than the fit may be wrong.
bool is_exchanged(const Estimate& estimate, const EstimateConfig& config) {
    if (config.order != Order::by_points) return config.order == Order::exchanged;
    if (config.is_rig) return false;
    const std::vector<double> disparities = estimate.disparities();
    const double low = quantile(disparities, 0.005), high = quantile(disparities, 0.995);
    const double unsure = kYawDeviations * estimate.camera.focal_px * estimate.fit.deviations[kYaw];
    if (high < 0) return true;
    return low < 0 && -low > std::max({3 * high, unsure, kClearlyBehind_px});
}

constexpr double kAcross_px = 4;  // rows between both places of a moved point, at least
// Shifts of neighbours differ by less, and by more the farther they are apart.
constexpr double kAlike_px = 2, kAlikeSlope = 0.05;
constexpr double kReach = 0.1;  // of the picture's width, within which neighbours lie
constexpr std::size_t kAlikeNeighbours = 4;
constexpr std::size_t kLeastPoints = 8;
constexpr double kLeastShare = 0.02;

struct Shifted {
    Point place, shift;
};

double distance(const Point& a, const Point& b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

}  // namespace

RowFigures row_figures(std::vector<double> offsets) {
    RowFigures figures;
    if (offsets.empty()) return figures;
    std::size_t beyond = 0;
    for (double& offset : offsets) {
        offset = std::fabs(offset);
        beyond += offset > 1;
    }
    figures.median_px = median(offsets);
    figures.percentile90_px = quantile(offsets, 0.9);
    figures.beyond_share = static_cast<double>(beyond) / static_cast<double>(offsets.size());
    return figures;
}

Views Estimate::views(double scale) const {
    const Views views = views_of(camera.scaled(scale), fit.parameters);
    return is_exchanged ? Views{views.right, views.left, views.focal_px} : views;
}

std::vector<double> Estimate::disparities() const {
    const Views ordered = views();
    std::vector<double> out;
    for (const Match& match : agreeing)
        out.push_back(ordered.disparity(is_exchanged ? Match{match.right, match.left} : match));
    return out;
}

Estimate estimate_views(const Camera& camera, const std::vector<Match>& matches, const EstimateConfig& config,
                        ThreadPool& pool) {
    Estimate estimate;
    estimate.camera = camera;
    estimate.matches = matches;
    find_start(estimate, config, pool);
    return with_matches(estimate, estimate.matches, config, pool);
}

Estimate with_matches(Estimate estimate, std::vector<Match> matches, const EstimateConfig& config,
                      ThreadPool& pool) {
    estimate.matches = std::move(matches);
    estimate.is_exchanged = false;
    const std::vector<Match>& all = estimate.matches;
    const std::vector<Match> some = at_most(supported(all), kMostFitted);
    const std::vector<Match> fitted = every(some, 0, 2), held_out = every(some, 1, 2);
    const auto fit_from_start = [&](const std::vector<Match>& to, const Prior& prior) {
        return fit_views(estimate.camera, to, prior, estimate.fit.parameters, kKnownWidth_px);
    };
    double costs_held_out[2];  // without and with a radial term
    pool.parallel_for_each(2, [&](int k) {
        costs_held_out[k] = row_cost(
            views_of(estimate.camera, fit_from_start(fitted, prior_of(config, k == 1)).parameters), held_out);
    });
    const bool has_radial = costs_held_out[1] < kRadialGain * costs_held_out[0];
    Prior prior = prior_of(config, has_radial);

    const auto take = [&](const Fit& fit) {
        estimate.fit = fit;
        estimate.agreeing.clear();
        const Views views = views_of(estimate.camera, fit.parameters);
        for (const Match& match : all)
            if (std::fabs(views.row_offset(match)) < kAgreeing_px) estimate.agreeing.push_back(match);
    };
    take(fit_from_start(some, prior));
    const bool seems_exchanged = is_exchanged(estimate, config);
    const Fit free = estimate.fit;
    prior.order = 1;
    take(fit_from_start(some, prior));
    // Rows of a flat scene hardly tell which way the cameras moved: then the order is the one that was given.
    estimate.is_exchanged = seems_exchanged && is_exchanged(estimate, config);
    if (estimate.is_exchanged) {
        estimate.fit = free;
        prior.order = -1;
        take(fit_from_start(some, prior));
    }

    const Views views = views_of(estimate.camera, estimate.fit.parameters);
    std::vector<double> before;
    for (const Match& match : estimate.agreeing) before.push_back(match.right.y - match.left.y);
    estimate.before = row_figures(std::move(before));
    estimate.after = row_figures(offsets_of(views, estimate.agreeing));
    std::vector<Match> agreeing_held_out;
    for (const Match& match : held_out)
        if (std::fabs(views.row_offset(match)) < kAgreeing_px) agreeing_held_out.push_back(match);
    estimate.held_out = row_figures(
        offsets_of(views_of(estimate.camera, fit_from_start(fitted, prior).parameters), agreeing_held_out));
    return estimate;
}

Movers find_movers(const Estimate& estimate) {
    const Views views = views_of(estimate.camera, estimate.fit.parameters);
    std::vector<Shifted> across;
    for (const Match& match : estimate.matches) {
        const Point left = views.left.rectified(match.left), right = views.right.rectified(match.right);
        if (std::fabs(right.y - left.y) > kAcross_px)
            across.push_back({match.left, {right.x - left.x, right.y - left.y}});
    }
    std::vector<double> x, y;
    for (const Shifted& point : across) {
        std::size_t alike = 0;
        for (const Shifted& other : across) {
            const double apart = distance(point.place, other.place);
            alike += &other != &point && apart < kReach * estimate.camera.width &&
                     distance(point.shift, other.shift) < kAlike_px + kAlikeSlope * apart;
        }
        if (alike < kAlikeNeighbours) continue;
        x.push_back(point.place.x);
        y.push_back(point.place.y);
    }
    if (x.size() < kLeastPoints ||
        static_cast<double>(x.size()) < kLeastShare * static_cast<double>(estimate.matches.size()))
        return {};
    Movers movers{static_cast<int>(x.size()), {median(x), median(y)}};
    if (estimate.is_quarter_turned)
        movers.middle = {estimate.camera.height - 1 - movers.middle.y, movers.middle.x};
    return movers;
}

}  // namespace hexrelief::alignment
