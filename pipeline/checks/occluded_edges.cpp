#include "pipeline/checks/occluded_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace hexrelief::checks {
namespace {

constexpr int kLeastRun_px = 3;
// By how much a run of unmatched pixels may be longer or shorter than the step of the disparity across it.
constexpr double kOffShare = 0.35, kOff_px = 2;
constexpr int kReach_px = 1;       // of an edge from the end of the run
constexpr double kStronger = 1.3;  // than the contrast at the run's other end
// Least number of runs with an edge at one end, and least share of them with the edge at the right end: it is
// 0.57 and more in left views with depth steps, 0.46 and less in right ones.
constexpr int kLeastEdges = 60;
constexpr double kLeastShare = 0.6;

// Returns the largest contrast of neighbours at the border between columns x and x + 1, or beside it.
int contrast_at(const Image& image, int x, int y) {
    int largest = 0;
    for (int at = std::max(0, x - kReach_px); at <= std::min(x + kReach_px, image.width - 2); ++at)
        for (int c = 0; c < image.channels; ++c)
            largest = std::max(largest, std::abs(image.at(at + 1, y)[c] - image.at(at, y)[c]));
    return largest;
}

struct Edges {
    int at_left = 0, at_right = 0;
    bool are_many() const { return at_left + at_right >= kLeastEdges; }
    double share_of(int some) const { return static_cast<double>(some) / (at_left + at_right); }
};

Edges edges_of(const stages::SmallMatch& match) {
    const matching::MatchedMap& map = match.map;
    const Image& image = match.small.pair.left;
    Edges edges;
    for (int y = 0; y < map.height; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * map.width;
        int before = -1;
        for (int x = 0; x < map.width; ++x) {
            const std::int16_t d = map.disparities[row + x];
            if (d == matching::kUnknown16) continue;
            const int run = x - before - 1;
            if (before >= 0 && run >= kLeastRun_px) {
                const double step =
                    (d - map.disparities[row + before]) / static_cast<double>(matching::kOnePixel);
                if (step >= kLeastRun_px && std::fabs(step - run) <= std::max(kOff_px, kOffShare * run)) {
                    const int left = contrast_at(image, before, y), right = contrast_at(image, x - 1, y);
                    edges.at_left += left > kStronger * right;
                    edges.at_right += right > kStronger * left;
                }
            }
            before = x;
        }
    }
    return edges;
}

}  // namespace

bool is_surely_left(const stages::SmallMatch& match) {
    const Edges edges = edges_of(match);
    return edges.are_many() && edges.share_of(edges.at_right) >= kLeastShare;
}

bool is_surely_right(const stages::SmallMatch& match) {
    const Edges edges = edges_of(match);
    return edges.are_many() && edges.share_of(edges.at_left) >= kLeastShare;
}

}  // namespace hexrelief::checks
