#include "pipeline/alignment/alignment.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "pipeline/alignment/fit.h"
#include "pipeline/alignment/grey_picture.h"
#include "pipeline/alignment/resample.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::alignment {
namespace {

constexpr double kInside_px = 16;  // from the picture's border, beyond which a patch is not known
constexpr int kSubpixels = 256;    // of a pixel, to which positions are rounded

// One of the aligned pictures, and where its points lie.
class AlignedPicture {
  public:
    AlignedPicture(const View& view, const Estimate& estimate, const Canvas& canvas, int x)
        : view_(view), estimate_(estimate), canvas_(canvas), x_(x) {}

    // Returns where the camera's picture, turned as the estimate's matches are, shows a pixel of the canvas.
    Point in_picture(const Point& on_canvas) const {
        return view_.in_picture({on_canvas.x + x_ + 0.5, on_canvas.y + canvas_.y + 0.5});
    }

    bool is_inside(const Point& p) const {
        const Camera& camera = estimate_.camera;
        return p.x >= kInside_px && p.y >= kInside_px && p.x < camera.width - kInside_px &&
               p.y < camera.height - kInside_px;
    }

    GreyPicture of(const GreyPicture& picture, ThreadPool& pool) const {
        GreyPicture out{canvas_.width, canvas_.height, {}};
        out.values.resize(static_cast<std::size_t>(out.width) * out.height);
        pool.parallel_for_each(out.height, [&](int y) {
            for (int x = 0; x < out.width; ++x)
                out.row(y)[x] = sample(picture, in_picture({1.0 * x, 1.0 * y}));
        });
        return out;
    }

  private:
    // Returns the picture's linear interpolation; its border repeats outside.
    std::uint8_t sample(const GreyPicture& picture, Point p) const {
        const Camera& camera = estimate_.camera;
        if (estimate_.is_quarter_turned) p = {camera.height - 1 - p.y, p.x};
        const double width = estimate_.is_quarter_turned ? camera.height : camera.width,
                     height = estimate_.is_quarter_turned ? camera.width : camera.height;
        const auto place = [](double at, double side, int pixels) {
            const double scaled = (at + 0.5) * pixels / side - 0.5;
            return static_cast<int>(std::clamp(scaled, 0.0, pixels - 1.0) * kSubpixels + 0.5);
        };
        const int x = place(p.x, width, picture.width), y = place(p.y, height, picture.height);
        const int column = x / kSubpixels, row = y / kSubpixels;
        const int next = std::min(column + 1, picture.width - 1);
        const std::uint8_t *const above = picture.row(row), *const below = picture.row(
                                                                std::min(row + 1, picture.height - 1));
        const int u = x % kSubpixels, v = y % kSubpixels;
        const int upper = above[column] * (kSubpixels - u) + above[next] * u,
                  lower = below[column] * (kSubpixels - u) + below[next] * u;
        return static_cast<std::uint8_t>(
            (upper * (kSubpixels - v) + lower * v + kSubpixels * kSubpixels / 2) / (kSubpixels * kSubpixels));
    }

    const View& view_;
    const Estimate& estimate_;
    const Canvas& canvas_;
    int x_;
};

// Returns matches like the estimate's own, found in the pictures as the estimate aligns them: patches that
// were turned or scaled against each other are alike then, so that there are more matches and truer ones.
// left, right: the pictures that the estimate's matches were found in.
std::vector<Match> look_again(const Estimate& estimate, const GreyPicture& left, const GreyPicture& right,
                              ThreadPool& pool) {
    const Canvas canvas = canvas_of(estimate, bounds_of(estimate, false, 1), 1);
    if (canvas.width <= 0) return estimate.matches;
    const bool is_exchanged = estimate.is_exchanged;
    const Views views = estimate.views();
    const AlignedPicture first(views.left, estimate, canvas, canvas.left_x),
        second(views.right, estimate, canvas, canvas.right_x);
    std::vector<Match> found = find_matches(first.of(is_exchanged ? right : left, pool),
                                            second.of(is_exchanged ? left : right, pool), pool);
    std::vector<Match> matches;
    for (const Match& match : found) {
        Match taken{first.in_picture(match.left), second.in_picture(match.right)};
        if (!first.is_inside(taken.left) || !second.is_inside(taken.right)) continue;
        if (is_exchanged) std::swap(taken.left, taken.right);
        matches.push_back(taken);
    }
    return matches;
}

constexpr int kWorkingSide_px = 1280;
constexpr double kGuessedFocal = 0.9;  // of the longer side: an angle of view of 58 degrees
constexpr double kDeterminedFocal = 0.03;

// What is rectified: rows off by less in the median, and by more than 1 px for fewer of the matches.
constexpr double kRectifiedMedian_px = 0.35, kRectifiedShare = 0.06;
// Matches that are off by no more rows tell whether a pair is rectified; of all, so many must be.
constexpr double kNearRow_px = 8, kLeastNear = 0.25;
constexpr double kGainOverNoise = 1.3;  // of the share that is off after the fit

constexpr int kLeastMatches = 40;
constexpr double kLeastAgreeing = 0.5;
constexpr int kParts = 8, kLeastParts = 8;  // a side of the picture has kParts parts
constexpr double kLargestRatio = 1.08;      // of the focal lengths; pictures of one camera have 1
constexpr double kLargestTurnCosine =
    0.848048096156426;  // of 32 degrees; a cosine, as processors agree on it
constexpr double kLargestRowMedian_px = 0.75, kLeastParallax_px = 3;

bool are_rows_aligned(const std::vector<Match>& matches) {
    std::vector<double> near;
    for (const Match& match : matches)
        if (const double row = match.right.y - match.left.y; std::fabs(row) <= kNearRow_px)
            near.push_back(row);
    if (static_cast<double>(near.size()) < kLeastNear * static_cast<double>(matches.size())) return false;
    const RowFigures rows = row_figures(std::move(near));
    return rows.median_px < kRectifiedMedian_px && rows.beyond_share < kRectifiedShare;
}

// True if aligning the rows would change little against what is left anyway.
bool is_insignificant(const Estimate& estimate) {
    return !estimate.is_quarter_turned && !estimate.is_exchanged &&
           estimate.before.median_px < kRectifiedMedian_px &&
           estimate.before.beyond_share <
               std::max(kRectifiedShare, kGainOverNoise * estimate.after.beyond_share);
}

int parts_seen(const Estimate& estimate) {
    std::vector<bool> seen(std::size_t{kParts} * kParts);
    for (const Match& match : estimate.agreeing) {
        const int column = static_cast<int>(match.left.x * kParts / estimate.camera.width),
                  row = static_cast<int>(match.left.y * kParts / estimate.camera.height);
        seen[static_cast<std::size_t>(std::clamp(row, 0, kParts - 1)) * kParts +
             static_cast<std::size_t>(std::clamp(column, 0, kParts - 1))] = true;
    }
    return static_cast<int>(std::count(seen.begin(), seen.end(), true));
}

// Returns the cosine of the larger of both cameras' angles to the rectified axis.
double turn_cosine(const Estimate& estimate) {
    const Views views = estimate.views();
    return std::min(views.left.axis_cosine(), views.right.axis_cosine());
}

// Returns why the pair cannot be aligned; empty = it can.
std::string obstacle(const Estimate& estimate) {
    const std::size_t agreeing = estimate.agreeing.size(), all = estimate.matches.size();
    const std::string of_all = std::to_string(agreeing) + " of " + std::to_string(all);
    const auto px = [&](double offset, int digits) {
        const Camera& camera = estimate.camera;
        return fixed(offset, digits) + " px of " + fixed(std::max(camera.width, camera.height), 0);
    };
    if (static_cast<double>(agreeing) < kLeastAgreeing * static_cast<double>(all) || agreeing < kLeastMatches)
        return "only " + of_all + " points agree: forward motion, a changed scene or a mirrored picture";
    if (const int parts = parts_seen(estimate); parts < kLeastParts)
        return "both pictures show only " + std::to_string(parts) + " of " + std::to_string(kParts * kParts) +
               " parts of the scene";
    if (const double cosine = turn_cosine(estimate); cosine < kLargestTurnCosine)
        return "the camera went forward, not sideways (" +
               fixed(std::acos(cosine) * 180 / std::acos(-1.0), 0) + " degrees off)";
    const double ratio = factor_of(estimate.fit.parameters[kFocalRatio]);
    if (const double larger = std::max(ratio, 1 / ratio); larger > kLargestRatio)
        return "the camera went forward, not sideways: one picture is " + fixed(100 * (larger - 1), 0) +
               " % larger";
    if (estimate.after.median_px > kLargestRowMedian_px)
        return "rows stay off by " + px(estimate.after.median_px, 2);
    const std::vector<double> disparities = estimate.disparities();
    const double parallax = quantile(disparities, 0.98) - quantile(disparities, 0.02);
    if (parallax < kLeastParallax_px)
        return "the camera was turned, not moved: points shift by " + px(parallax, 1);
    return {};
}

// Brings matches of the reduced pictures to one scale along both sides: rounding made one a little larger.
void rescale(std::vector<Match>& matches, const GreyPicture& reduced, const Camera& camera) {
    const double x = camera.width / reduced.width, y = camera.height / reduced.height;
    for (Match& match : matches)
        for (Point* p : {&match.left, &match.right}) *p = {(p->x + 0.5) * x - 0.5, (p->y + 0.5) * y - 0.5};
}

// A toe-in that rows and matches tell may be wrong by so much, whatever the fit says.
constexpr double kLeastYawDeviation = 0.15 * kDegree, kLeastYawDeviationGuessed = 0.3 * kDegree;
// Farthest over nearest distance, at most: if infinity is not known, and if it is.
constexpr double kFarthest = 4, kFarthestKnown = 40;
constexpr double kDeepForWide = 0.25;  // a scene whose infinity is not known: its depth over its width
constexpr std::size_t kLeastForSupport = 30, kLeastSupported = 20;

// Returns the disparities of matches that those around them have nearly as well: a repeated pattern slides
// along rows unnoticed.
std::vector<double> supported(const std::vector<Match>& matches, const std::vector<double>& disparities) {
    if (matches.size() < kLeastForSupport) return disparities;
    std::vector<Point> shifts;
    for (const double d : disparities) shifts.push_back({d, 0});
    std::vector<double> out;
    for (const std::size_t i : supported_by_neighbours(matches, shifts)) out.push_back(disparities[i]);
    return out.size() >= kLeastSupported ? out : disparities;
}

// Returns farthest over nearest distance of a scene that is kDeepForWide times as deep as its far end is
// wide. width: of the picture, in focal lengths.
double farthest_for(double width) {
    const double deep = std::min(kDeepForWide * width, 1 - 1 / kFarthest);
    return 1 / (1 - deep);
}

// unsure_px: how far the disparity of infinity, 0, may be off. width: as above.
DisparityBounds bounds_by(const std::vector<double>& disparities, double unsure_px, double scale,
                          double width) {
    const double low = quantile(disparities, 0.005), high = quantile(disparities, 0.995);
    DisparityBounds bounds{.is_infinity_known = low >= unsure_px};
    const double infinity = bounds.is_infinity_known
                                ? std::min(0.0, low - (high - low) / (kFarthestKnown - 1))
                                : low - (high - low) / (farthest_for(width) - 1);
    bounds.least_px = low / scale;
    bounds.largest_px = high / scale;
    bounds.median_px = median(disparities) / scale;
    bounds.infinity_px = infinity / scale;
    return bounds;
}

}  // namespace

bool Alignment::is_focal_determined() const {
    return focal_deviation < kDeterminedFocal;
}

Alignment find_alignment(const StereoPair& pair, const AlignmentConfig& config, int threads) {
    ThreadPool pool(threads);
    const GreyPicture left = reduced_grey(pair.left, kWorkingSide_px, pool),
                      right = reduced_grey(pair.right, kWorkingSide_px, pool);
    const double longer = std::max(pair.left.width, pair.left.height);
    const double scale = std::min(1.0, kWorkingSide_px / longer);
    const bool is_focal_known = config.focal_px > 0;
    const Camera camera{scale * pair.left.width, scale * pair.left.height,
                        scale * (is_focal_known ? config.focal_px : kGuessedFocal * longer)};
    std::vector<Match> matches = find_matches(left, right, pool);
    rescale(matches, left, camera);

    Alignment out;
    out.matches = static_cast<int>(matches.size());
    if (matches.size() < kLeastMatches) {
        out.reason = "only " + std::to_string(matches.size()) + " points are in both pictures";
        return out;
    }
    if (!config.always && config.order != Order::exchanged && are_rows_aligned(matches)) {
        out.verdict = Verdict::rectified;
        out.estimate = as_given(camera, std::move(matches));
        out.disparities = bounds_as_given(out.estimate, scale);
        return out;
    }
    const EstimateConfig estimating{is_focal_known, config.is_rig, config.order};
    Estimate& estimate = out.estimate = estimate_views(camera, matches, estimating, pool);
    out.reason = obstacle(estimate);
    if (out.reason.empty()) {
        std::vector<Match> again = look_again(estimate, left, right, pool);
        if (again.size() >= kLeastMatches) {
            Estimate second = with_matches(estimate, std::move(again), estimating, pool);
            if (second.held_out.median_px < estimate.held_out.median_px && obstacle(second).empty())
                estimate = std::move(second);
        }
    }
    out.matches = static_cast<int>(estimate.matches.size());
    if (!config.always && is_insignificant(estimate)) {
        out.verdict = Verdict::rectified;
        out.reason.clear();
        out.disparities = bounds_as_given(estimate, scale);
        return out;
    }
    out.verdict = out.reason.empty() ? Verdict::aligned : Verdict::refused;
    if (out.verdict == Verdict::refused) return out;
    out.focal_px = estimate.views(1 / scale).focal_px;
    out.focal_deviation = estimate.fit.deviations[kFocal];
    const DisparityBounds found = bounds_of(estimate, is_focal_known, scale);
    out.canvas = canvas_of(estimate, found, scale);
    if (out.canvas.width <= 0) {
        out.verdict = Verdict::refused;
        out.reason = "the pictures share too little of the scene";
        return out;
    }
    out.disparities = on_canvas(found, out.canvas);
    out.movers = find_movers(estimate);
    out.movers.middle = {out.movers.middle.x / scale, out.movers.middle.y / scale};
    return out;
}

DisparityBounds bounds_of(const Estimate& estimate, bool is_focal_known, double scale) {
    const double least = is_focal_known ? kLeastYawDeviation : kLeastYawDeviationGuessed;
    const double unsure_px = 2 * estimate.views().focal_px * std::max(least, estimate.fit.deviations[kYaw]);
    return bounds_by(supported(estimate.agreeing, estimate.disparities()), unsure_px, scale,
                     estimate.camera.width / estimate.views().focal_px);
}

DisparityBounds bounds_as_given(const Estimate& estimate, double scale) {
    std::vector<double> disparities;
    for (const Match& match : estimate.agreeing) disparities.push_back(match.left.x - match.right.x);
    const double unsure_px = 0;  // a rectified pair has its infinity at 0, unless some of it lies behind
    return bounds_by(supported(estimate.agreeing, disparities), unsure_px, scale,
                     estimate.camera.width / estimate.camera.focal_px);
}

Estimate as_given(const Camera& camera, std::vector<Match> matches) {
    Estimate estimate;
    estimate.camera = camera;
    std::vector<double> rows;
    for (const Match& match : matches) {
        const double row = match.right.y - match.left.y;
        if (std::fabs(row) >= kAgreeing_px) continue;
        estimate.agreeing.push_back(match);
        rows.push_back(row);
    }
    estimate.matches = std::move(matches);
    estimate.before = estimate.after = estimate.held_out = row_figures(std::move(rows));
    return estimate;
}

}  // namespace hexrelief::alignment
