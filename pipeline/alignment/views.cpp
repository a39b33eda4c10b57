#include "pipeline/alignment/views.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::alignment {
namespace {

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
