#include "pipeline/alignment/movers.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/alignment/median.h"

namespace hexrelief::alignment {
namespace {

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
