#include "pipeline/alignment/fit.h"

#include <cmath>
#include <optional>

namespace hexrelief::alignment {
namespace {

constexpr double kLeastLength = 0.1;  // of the focal length, between points that tell a roll

// Returns the median roll parameter, by pairs of points that lie in different parts of the picture.
double roll_of(std::vector<Match> matches, double focal_px) {
    std::stable_sort(matches.begin(), matches.end(),
                     [](const Match& a, const Match& b) { return a.left.x < b.left.x; });
    std::vector<double> rolls;
    const std::size_t half = matches.size() / 2;
    for (std::size_t i = 0; i < half; ++i) {
        const Match &a = matches[i], &b = matches[i + half];
        const double left_x = b.left.x - a.left.x, left_y = b.left.y - a.left.y;
        const double right_x = b.right.x - a.right.x, right_y = b.right.y - a.right.y;
        const double left_length = std::sqrt(left_x * left_x + left_y * left_y);
        const double lengths = left_length * std::sqrt(right_x * right_x + right_y * right_y);
        const double sine = left_x * right_y - left_y * right_x, cosine = left_x * right_x + left_y * right_y;
        if (left_length > kLeastLength * focal_px && lengths + cosine > 0)
            rolls.push_back(-2 * sine / (lengths + cosine));
    }
    return median(std::move(rolls));
}

constexpr double kNoise_px = 0.5;         // one standard deviation of a match's row
constexpr double kMostIndependent = 300;  // matches lie in clusters: more do not count as independent
constexpr double kFirstWidth_px = 4, kLastWidth_px = 1, kNarrowing = 1.5;
constexpr int kSteps = 12, kLastSteps = 30, kTries = 8;
constexpr double kConverged = 1e-7;
constexpr double kBehindCost = 16, kBehindWidth_px = 4;
constexpr double kMostFocal = 0.5, kMostRadial = 0.25;  // more is not believed
constexpr double kLargestTurnStep = 0.2, kLargestOtherStep = 0.3;
constexpr double kDifference = 1e-6;     // of a parameter, for derivatives
constexpr double kResolution = 1 << 20;  // of a fit's result

using Matrix = std::array<Parameters, kParameters>;

// Returns the lower factor of a positive definite matrix by Cholesky; only the first `count` rows.
std::optional<Matrix> factored(const Matrix& a, std::size_t count) {
    Matrix l{};
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = a[i][j];
            for (std::size_t k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
            if (i == j && !(sum > 0)) return std::nullopt;
            l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
        }
    return l;
}

Parameters solved(const Matrix& l, Parameters b, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < i; ++k) b[i] -= l[i][k] * b[k];
        b[i] /= l[i][i];
    }
    for (std::size_t i = count; i-- > 0;) {
        for (std::size_t k = i + 1; k < count; ++k) b[i] -= l[k][i] * b[k];
        b[i] /= l[i][i];
    }
    return b;
}

// The rows' offset of a match and how far it lies behind infinity, both in px.
struct Residual {
    double row = 0, behind = 0;
};

class Fitter {
  public:
    Fitter(const Camera& camera, const std::vector<Match>& matches, const Prior& prior)
        : camera_(camera), matches_(matches), prior_(prior) {
        const double count = static_cast<double>(matches.size());
        row_weight_ = std::min(1.0, kMostIndependent / count) / (kNoise_px * kNoise_px);
        behind_weight_ = kBehindCost / (count * kBehindWidth_px * kBehindWidth_px);
        for (std::size_t k = 0; k < kParameters; ++k)
            if (prior.deviations[k] > 0) free_.push_back(k);
    }

    Fit run(Parameters at, double width) {
        if (width <= 0) width = first_width(at);
        for (;; width = std::max(kLastWidth_px, width / kNarrowing)) {
            const bool is_last = width <= kLastWidth_px;
            double damping = 1e-3;
            for (int i = 0; i < (is_last ? kLastSteps : kSteps); ++i)
                if (step(at, width, damping) < kConverged) break;
            if (is_last) break;
        }
        return result(at, width);
    }

  private:
    double first_width(const Parameters& at) const {
        std::vector<double> rows;
        for (const Residual& r : residuals(at)) rows.push_back(r.row);
        const double middle = median(rows);
        for (double& row : rows) row = std::fabs(row - middle);
        return std::max(kFirstWidth_px, 3 * median(rows) + std::fabs(middle));
    }

    std::vector<Residual> residuals(const Parameters& at) const {
        const Views views = views_of(camera_, at);
        std::vector<Residual> out;
        out.reserve(matches_.size());
        for (const Match& match : matches_) {
            const Point left = views.left.rectified(match.left), right = views.right.rectified(match.right);
            out.push_back({right.y - left.y, std::max(0.0, prior_.order * (right.x - left.x))});
        }
        return out;
    }

    double cost(const std::vector<Residual>& residuals, const Parameters& at, double width) const {
        double rows = 0, behind = 0, prior = 0;
        const auto robust = [](double r, double w) { return w * w * r * r / (w * w + r * r); };
        for (const Residual& r : residuals) {
            rows += robust(r.row, width);
            behind += robust(r.behind, kBehindWidth_px);
        }
        for (const std::size_t k : free_)
            prior += at[k] * at[k] / (prior_.deviations[k] * prior_.deviations[k]);
        return row_weight_ * rows + behind_weight_ * behind + prior;
    }

    // The normal equations at a point; its gradient is that of half the cost.
    struct Normal {
        Matrix matrix{};
        Parameters gradient{};
    };

    Normal normal(const std::vector<Residual>& residuals_at, const Parameters& at, double width) const {
        std::vector<std::vector<Residual>> moved;
        for (const std::size_t k : free_) {
            Parameters next = at;
            next[k] += kDifference;
            moved.push_back(residuals(next));
        }
        const auto weight = [](double r, double w) {
            const double share = w * w / (w * w + r * r);
            return share * share;
        };
        Normal out;
        for (std::size_t m = 0; m < matches_.size(); ++m) {
            const Residual& r = residuals_at[m];
            const double row = row_weight_ * weight(r.row, width);
            const double behind = behind_weight_ * weight(r.behind, kBehindWidth_px);
            std::array<Residual, kParameters> slope;
            for (std::size_t i = 0; i < free_.size(); ++i)
                slope[i] = {(moved[i][m].row - r.row) / kDifference,
                            (moved[i][m].behind - r.behind) / kDifference};
            for (std::size_t i = 0; i < free_.size(); ++i) {
                for (std::size_t j = 0; j <= i; ++j)
                    out.matrix[i][j] +=
                        row * slope[i].row * slope[j].row + behind * slope[i].behind * slope[j].behind;
                out.gradient[i] += row * slope[i].row * r.row + behind * slope[i].behind * r.behind;
            }
        }
        for (std::size_t i = 0; i < free_.size(); ++i) {
            const double deviation = prior_.deviations[free_[i]];
            out.matrix[i][i] += 1 / (deviation * deviation);
            out.gradient[i] += at[free_[i]] / (deviation * deviation);
        }
        return out;
    }

    static double limited(std::size_t k, double value) {
        if (k == kFocal) return std::clamp(value, -kMostFocal, kMostFocal);
        if (k == kRadial) return std::clamp(value, -kMostRadial, kMostRadial);
        return value;
    }

    // Moves to a point of less cost. Returns the largest change of a parameter; 0 = there is no such point.
    double step(Parameters& at, double width, double& damping) const {
        const std::vector<Residual> here = residuals(at);
        const Normal normal_at = normal(here, at, width);
        const double before = cost(here, at, width);
        for (int attempt = 0; attempt < kTries; ++attempt, damping *= 5) {
            Matrix damped = normal_at.matrix;
            for (std::size_t i = 0; i < free_.size(); ++i) damped[i][i] *= 1 + damping;
            const auto factor = factored(damped, free_.size());
            if (!factor) continue;
            const Parameters change = solved(*factor, normal_at.gradient, free_.size());
            Parameters next = at;
            double largest = 0;
            for (std::size_t i = 0; i < free_.size(); ++i) {
                const std::size_t k = free_[i];
                const double most = k <= kCommonRoll ? kLargestTurnStep : kLargestOtherStep;
                next[k] = limited(k, at[k] - std::clamp(change[i], -most, most));
                largest = std::max(largest, std::fabs(next[k] - at[k]));
            }
            if (!(cost(residuals(next), next, width) <= before)) continue;
            damping = std::max(damping / 4, 1e-9);
            at = next;
            return largest;
        }
        return 0;
    }

    Fit result(const Parameters& at, double width) const {
        Fit fit;
        for (const std::size_t k : free_)
            fit.parameters[k] = std::floor(at[k] * kResolution + 0.5) / kResolution;
        const auto factor = factored(normal(residuals(at), at, width).matrix, free_.size());
        for (std::size_t i = 0; factor && i < free_.size(); ++i) {
            Parameters unit{};
            unit[i] = 1;
            fit.deviations[free_[i]] = std::sqrt(solved(*factor, unit, free_.size())[i]);
        }
        return fit;
    }

    const Camera& camera_;
    const std::vector<Match>& matches_;
    const Prior& prior_;
    double row_weight_ = 0, behind_weight_ = 0;
    std::vector<std::size_t> free_;
};

constexpr double kLeastForward = 0.05;  // of a ray along the axis: what is more oblique counts as this
constexpr int kStraightenings = 12;     // halve the error each, and far more for small distortions

// The sine and cosine of the angle that a parameter stands for.
struct Turn {
    double sine, cosine;

    explicit Turn(double parameter) {
        const double quarter = parameter * parameter / 4;
        sine = parameter / (1 + quarter);
        cosine = (1 - quarter) / (1 + quarter);
    }
};

// Returns pitch * yaw * roll: a camera is first rolled, then turned, then tilted.
View::Rotation rotation_of(double pitch, double yaw, double roll) {
    const Turn x(pitch), y(yaw), z(roll);
    return {y.cosine * z.cosine,
            -y.cosine * z.sine,
            y.sine,
            x.sine * y.sine * z.cosine + x.cosine * z.sine,
            x.cosine * z.cosine - x.sine * y.sine * z.sine,
            -x.sine * y.cosine,
            x.sine * z.sine - x.cosine * y.sine * z.cosine,
            x.cosine * y.sine * z.sine + x.sine * z.cosine,
            x.cosine * y.cosine};
}

}  // namespace

std::vector<Parameters> starts_of(const Camera& camera, const std::vector<Match>& matches) {
    std::vector<double> right, down;
    for (const Match& match : matches) {
        right.push_back((match.left.x - match.right.x) / camera.focal_px);
        down.push_back((match.right.y - match.left.y) / camera.focal_px);
    }
    Parameters turned{};
    turned[kPitch] = parameter_of_tangent(median(std::move(down)));
    turned[kRoll] = roll_of(matches, camera.focal_px);
    Parameters converging = turned;
    converging[kYaw] = parameter_of_tangent(median(std::move(right)));
    return {Parameters{}, turned, converging};
}

Fit fit_views(const Camera& camera, const std::vector<Match>& matches, const Prior& prior,
              const Parameters& start, double width_px) {
    return Fitter(camera, matches, prior).run(start, width_px);
}

double row_cost(const Views& views, const std::vector<Match>& matches) {
    double sum = 0;
    for (const Match& match : matches) {
        const double r = views.row_offset(match);
        sum += r * r / (1 + r * r);
    }
    return sum / static_cast<double>(matches.size());
}

Angles angles_of(const Parameters& p) {
    const auto degrees = [](double parameter) { return 2 * std::atan(parameter / 2) / kDegree; };
    const double left_yaw = degrees(p[kCommonYaw] - p[kYaw] / 2),
                 right_yaw = degrees(p[kCommonYaw] + p[kYaw] / 2),
                 left_roll = degrees(p[kCommonRoll] - p[kRoll] / 2),
                 right_roll = degrees(p[kCommonRoll] + p[kRoll] / 2);
    return {2 * degrees(p[kPitch] / 2), right_yaw - left_yaw, right_roll - left_roll,
            (left_yaw + right_yaw) / 2, (left_roll + right_roll) / 2};
}

double parameter_of_tangent(double tangent) {
    return 2 * tangent / (1 + std::sqrt(1 + tangent * tangent));
}

View::View(const Camera& camera, double focal_px, double rectified_focal_px, double radial,
           const Rotation& rotation)
    : middle_x_(0.5 * (camera.width - 1)),
      middle_y_(0.5 * (camera.height - 1)),
      per_half_diagonal2_(4.0 / (camera.width * camera.width + camera.height * camera.height)),
      focal_px_(focal_px),
      rectified_focal_px_(rectified_focal_px),
      radial_(radial),
      rotation_(rotation) {}

Point View::rectified(const Point& in_picture) const {
    const double bent_x = in_picture.x - middle_x_, bent_y = in_picture.y - middle_y_;
    const double straighten =
        (1 + radial_ * (bent_x * bent_x + bent_y * bent_y) * per_half_diagonal2_) / focal_px_;
    const double x = bent_x * straighten, y = bent_y * straighten;
    const Rotation& r = rotation_;
    const double forward = std::max(kLeastForward, r[6] * x + r[7] * y + r[8]);
    const double scale = rectified_focal_px_ / forward;
    return {scale * (r[0] * x + r[1] * y + r[2]), scale * (r[3] * x + r[4] * y + r[5])};
}

Point View::in_picture(const Point& rectified) const {
    const double x = rectified.x / rectified_focal_px_, y = rectified.y / rectified_focal_px_;
    const Rotation& r = rotation_;  // its transpose is its inverse
    const double forward = std::max(kLeastForward, r[2] * x + r[5] * y + r[8]);
    const double scale = focal_px_ / forward;
    const double straight_x = scale * (r[0] * x + r[3] * y + r[6]),
                 straight_y = scale * (r[1] * x + r[4] * y + r[7]);
    double bent_x = straight_x, bent_y = straight_y;
    if (radial_ != 0)
        for (int i = 0; i < kStraightenings; ++i) {
            const double straighten = 1 + radial_ * (bent_x * bent_x + bent_y * bent_y) * per_half_diagonal2_;
            bent_x = straight_x / straighten;
            bent_y = straight_y / straighten;
        }
    return {bent_x + middle_x_, bent_y + middle_y_};
}

Views views_of(const Camera& camera, const Parameters& p) {
    const double left_focal = camera.focal_px * factor_of(p[kFocal]);
    const double right_focal = left_focal * factor_of(p[kFocalRatio]);
    const auto turned = [&](double half) {
        return rotation_of(half * p[kPitch], p[kCommonYaw] + half * p[kYaw],
                           p[kCommonRoll] + half * p[kRoll]);
    };
    return {View(camera, left_focal, left_focal, p[kRadial], turned(-0.5)),
            View(camera, right_focal, left_focal, p[kRadial], turned(0.5)), left_focal};
}

}  // namespace hexrelief::alignment
