#include "pipeline/alignment/matches.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>

#include "pipeline/alignment/corners.h"

namespace hexrelief::alignment {
namespace {

constexpr int kLevels = 3;
constexpr int kLeastSide = 100;     // px of the smallest picture looked at
constexpr int kMostCorners = 3000;  // of a picture
constexpr int kAreaOfCorner = 100;  // px: small pictures have fewer corners
constexpr int kMostDifferent = 80;  // bits of 256
constexpr int kLead_percent = 80;   // of the distance of the second best
constexpr int kSamePlace = 3;       // px: the second best lies farther than this from the best
constexpr int kPatch = 7;           // px on each side of a patch's middle
constexpr int kReach = 2;           // px that a match is moved when it is refined
constexpr int kPatchPixels = (2 * kPatch + 1) * (2 * kPatch + 1);
constexpr int kPlaces = 2 * kReach + 1;

struct Candidate {
    int index = -1;  // of a right corner; -1 = none
    int bits = 0;
};

// Returns the right corner that describes a left one clearly best.
Candidate best_of(const Corner& corner, const std::vector<Corner>& others, std::vector<int>& distances) {
    Candidate best{-1, kMostDifferent};
    for (std::size_t j = 0; j < others.size(); ++j) {
        distances[j] = distance(corner.descriptor, others[j].descriptor);
        if (distances[j] < best.bits) best = {static_cast<int>(j), distances[j]};
    }
    if (best.index < 0) return best;
    const Corner& at = others[static_cast<std::size_t>(best.index)];
    for (std::size_t j = 0; j < others.size(); ++j)
        if (100 * best.bits >= kLead_percent * distances[j] &&
            (std::abs(others[j].x - at.x) > kSamePlace || std::abs(others[j].y - at.y) > kSamePlace))
            return {};
    return best;
}

// True if no other left corner describes the right one better, nor an earlier one as well.
bool is_mutual(std::size_t index, const Candidate& candidate, const Corner& right,
               const std::vector<Corner>& corners) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const int bits = distance(corners[i].descriptor, right.descriptor);
        if (bits < candidate.bits || (bits == candidate.bits && i < index)) return false;
    }
    return true;
}

bool fits(const GreyPicture& picture, int x, int y, int reach) {
    return x >= reach && y >= reach && x < picture.width - reach && y < picture.height - reach;
}

// Returns kPatchPixels times the sum of squared differences of two patches, each less its mean.
std::int64_t difference(const GreyPicture& left, int x, int y, const GreyPicture& right, int u, int v) {
    std::int64_t squares = 0, sum = 0;
    for (int j = -kPatch; j <= kPatch; ++j) {
        const std::uint8_t *const a = left.row(y + j) + x - kPatch, *const b = right.row(v + j) + u - kPatch;
        int row_squares = 0, row_sum = 0;
        for (int i = 0; i <= 2 * kPatch; ++i) {
            const int d = a[i] - b[i];
            row_squares += d * d;
            row_sum += d;
        }
        squares += row_squares;
        sum += row_sum;
    }
    return kPatchPixels * squares - sum * sum;
}

// Returns the least place of a parabola through three costs, the middle one being the least, in 1/64 px.
int least_place(std::int64_t before, std::int64_t at, std::int64_t after) {
    return static_cast<int>(64 * (before - after) / (2 * std::max<std::int64_t>(1, before + after - 2 * at)));
}

// Returns where the left corner lies in the right picture, near a corner of that; none if it is not clear.
std::optional<Point> refined(const GreyPicture& left, const Corner& a, const GreyPicture& right,
                             const Corner& b) {
    if (!fits(left, a.x, a.y, kPatch) || !fits(right, b.x, b.y, kPatch + kReach)) return std::nullopt;
    std::array<std::array<std::int64_t, kPlaces>, kPlaces> costs{};
    int best_x = 0, best_y = 0;
    for (int j = 0; j < kPlaces; ++j)
        for (int i = 0; i < kPlaces; ++i) {
            costs[j][i] = difference(left, a.x, a.y, right, b.x + i - kReach, b.y + j - kReach);
            if (costs[j][i] < costs[best_y][best_x]) {
                best_x = i;
                best_y = j;
            }
        }
    if (best_x == 0 || best_y == 0 || best_x == kPlaces - 1 || best_y == kPlaces - 1) return std::nullopt;
    const std::int64_t least = costs[best_y][best_x];
    const int part_x = least_place(costs[best_y][best_x - 1], least, costs[best_y][best_x + 1]),
              part_y = least_place(costs[best_y - 1][best_x], least, costs[best_y + 1][best_x]);
    return Point{b.x + best_x - kReach + part_x / 64.0, b.y + best_y - kReach + part_y / 64.0};
}

void match_level(const GreyPicture& left, const GreyPicture& right, int level, ThreadPool& pool,
                 std::vector<Match>& matches) {
    const int area = left.width * left.height;
    const int count = std::min(kMostCorners >> (2 * level), area / kAreaOfCorner);
    const std::vector<Corner> corners = find_corners(left, count, pool),
                              others = find_corners(right, count, pool);
    std::vector<std::optional<Point>> found(corners.size());
    pool.parallel_for_chunks(corners.size(), [&](std::size_t first, std::size_t last) {
        std::vector<int> distances(others.size());
        for (std::size_t i = first; i < last; ++i) {
            const Candidate best = best_of(corners[i], others, distances);
            if (best.index < 0) continue;
            const Corner& other = others[static_cast<std::size_t>(best.index)];
            if (is_mutual(i, best, other, corners)) found[i] = refined(left, corners[i], right, other);
        }
    });
    const double scale = 1 << level, shift = 0.5 * (scale - 1);  // a reduced pixel's middle
    for (std::size_t i = 0; i < corners.size(); ++i)
        if (found[i])
            matches.push_back({{corners[i].x * scale + shift, corners[i].y * scale + shift},
                               {found[i]->x * scale + shift, found[i]->y * scale + shift}});
}

}  // namespace

std::vector<Match> find_matches(const GreyPicture& left, const GreyPicture& right, ThreadPool& pool) {
    std::vector<Match> matches;
    GreyPicture a = left, b = right;
    for (int level = 0; level < kLevels; ++level) {
        if (std::min({a.width, a.height, b.width, b.height}) < kLeastSide) break;
        match_level(a, b, level, pool, matches);
        a = halved(a);
        b = halved(b);
    }
    return matches;
}

}  // namespace hexrelief::alignment
