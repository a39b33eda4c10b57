// The model of two cameras side by side, and the fit of its parameters to matches: they bring each match to
// one row.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "pipeline/alignment/matches.h"

namespace hexrelief::alignment {

// Two cameras side by side as seen from the pair that they should have taken: the model that is fitted. All
// parameters are 0 if the pair is rectified and the focal length is as guessed. An angle a stands as
// 2 tan(a / 2), a ratio r as 2 (r - 1) / (r + 1), so that the model needs no function beyond + - * / sqrt,
// which all processors compute alike. The pair's relative angles turn each camera by half; a common pitch
// would change nothing.
enum Parameter : std::size_t {
    kPitch,
    kYaw,
    kCommonYaw,
    kRoll,
    kCommonRoll,
    kFocal,       // left focal length over its guess
    kFocalRatio,  // right focal length over the left one
    kRadial,      // distortion of both at half the diagonal: straight = bent * (1 + radial * r^2)
    kParameters
};
using Parameters = std::array<double, kParameters>;

// The parameter of one degree, near 0.
inline constexpr double kDegree = 0.017453292519943295;

// Returns the factor that a ratio's parameter stands for.
inline double factor_of(double parameter) {
    return (2 + parameter) / (2 - parameter);
}

// The angles that parameters stand for, in degrees: of the right camera less those of the left one, and the
// means of both. For messages: they come from the library's arc tangent.
struct Angles {
    double pitch = 0, yaw = 0, roll = 0, common_yaw = 0, common_roll = 0;
};
Angles angles_of(const Parameters& parameters);

// Returns the parameter of the angle with this tangent.
double parameter_of_tangent(double tangent);

// What is known of both cameras before the fit; lengths in px of one and the same size of their pictures.
struct Camera {
    double width = 0, height = 0;
    double focal_px = 0;  // guessed or known

    Camera scaled(double by) const { return {by * width, by * height, by * focal_px}; }
};

// One camera with given parameters. Rectified positions are in px at the left focal length, from the
// principal point.
class View {
  public:
    using Rotation = std::array<double, 9>;  // row-major: rectified ray = rotation * ray of the camera

    View(const Camera& camera, double focal_px, double rectified_focal_px, double radial,
         const Rotation& rotation);

    // Returns where the rectified view shows what the picture shows here.
    Point rectified(const Point& in_picture) const;
    // Returns the inverse.
    Point in_picture(const Point& rectified) const;
    // Cosine of the angle between the camera's axis and the rectified one.
    double axis_cosine() const { return rotation_[8]; }

  private:
    double middle_x_, middle_y_, per_half_diagonal2_;
    double focal_px_, rectified_focal_px_, radial_;
    Rotation rotation_;
};

struct Views {
    View left, right;
    double focal_px;  // of the rectified views

    double row_offset(const Match& match) const {
        return right.rectified(match.right).y - left.rectified(match.left).y;
    }
    double disparity(const Match& match) const {
        return left.rectified(match.left).x - right.rectified(match.right).x;
    }
};

Views views_of(const Camera& camera, const Parameters& parameters);

// Returns the parameters of cameras that stand parallel; that are turned so that the matches lie on the same
// rows on average; and that are turned towards the same places as well. Needs at least 2 matches.
std::vector<Parameters> starts_of(const Camera& camera, const std::vector<Match>& matches);

// What is believed before the fit.
struct Prior {
    // One standard deviation of each parameter from 0; 0 = held at 0.
    Parameters deviations = {};
    // 1 = the scene lies in front of both cameras if the pictures are in order, -1 = if they are exchanged;
    // 0 = not asked. The belief is soft: all matches behind infinity weigh as much as a parameter that is
    // four standard deviations off.
    int order = 0;
};

struct Fit {
    Parameters parameters = {};  // rounded to 2^-20
    Parameters deviations = {};  // one standard deviation of each after the fit; 0 if held
};

// Minimises the rows' offsets by Levenberg-Marquardt steps, with Geman-McClure weights whose width falls from
// that of the rows at the start (or from `width_px` if that is above 0) to 1 px. Matches are summed in their
// order and nothing is drawn at random: the same input gives the same bits. Needs at least 8 matches.
Fit fit_views(const Camera& camera, const std::vector<Match>& matches, const Prior& prior,
              const Parameters& start, double width_px = 0);

// Returns the mean of r^2 / (1 + r^2) over the rows' offsets: 0 = all on their rows, 1 = none.
double row_cost(const Views& views, const std::vector<Match>& matches);

// Returns the value below which this share of the values lies, 0 to 1; 0 if there are none.
inline double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto place = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(place);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

inline double median(std::vector<double> values) {
    return quantile(std::move(values), 0.5);
}

}  // namespace hexrelief::alignment
