#include "pipeline/alignment/starts.h"

#include <algorithm>
#include <cmath>

#include "pipeline/alignment/median.h"

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

}  // namespace hexrelief::alignment
