// Fits one plane to scattered disparities of which many may be wrong.
#pragma once

#include <optional>
#include <vector>

namespace hexrelief::stages {

// A match: its place, px, its disparity, and its share of all weights.
struct PlaneSample {
    float x, y, disparity, weight;
};

// disparity = x_slope * x + y_slope * y + at_origin.
struct DisparityPlane {
    double x_slope = 0, y_slope = 0, at_origin = 0;

    double at(double x, double y) const { return x_slope * x + y_slope * y + at_origin; }
};

inline constexpr double kOnPlane_px = 1;  // farther from it a sample is none of the plane's

struct PlaneFit {
    DisparityPlane plane;
    double share = 0;         // the weight of the samples on the plane
    double second_share = 0;  // the most that another plane holds of the samples 1.5 px or more off this one
};

// Returns the plane that holds the most weight of 200 planes through three samples each, which are the same
// in every run, and of 24 that face the camera; then moved to the samples near it by least squares,
// reweighted five times. Returns none if it holds less than `least_share`. samples: three or more. Sums have
// one order.
std::optional<PlaneFit> fit_plane(const std::vector<PlaneSample>& samples, double least_share);

}  // namespace hexrelief::stages
