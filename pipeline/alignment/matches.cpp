#include "pipeline/alignment/matches.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <utility>

#include "pipeline/base/uninitialized_vector.h"

namespace hexrelief::alignment {
namespace {

constexpr int kCells = 12;      // a side of the picture has so many parts
constexpr int kBorder_px = 20;  // px: a descriptor reaches 15 px
constexpr int kApart = 3;       // px between corners
constexpr std::size_t kNeighbours = 8, kSupporting = 3;
constexpr double kSupport_px = 2, kSupportSlope = 0.1;
constexpr std::int64_t kLeastStrength =
    9600;  // 16 times the sum of 25 squared gradients of some 5 grey levels

// A raster of whole numbers, which the threads that fill it touch first.
struct Sums {
    int width = 0, height = 0;
    RawVector<std::int32_t> values;

    Sums(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * h) {}
    const std::int32_t* row(int y) const { return values.data() + static_cast<std::size_t>(y) * width; }
    std::int32_t* row(int y) { return values.data() + static_cast<std::size_t>(y) * width; }
};

// Returns sums over 5 x 5 px of value(x, y); those within 2 px of the border are not set.
template <typename Value>
Sums box_sums(int width, int height, ThreadPool& pool, const Value& value) {
    Sums across(width, height), out(width, height);
    pool.parallel_for_each(height, [&](int y) {
        std::int32_t* const to = across.row(y);
        for (int x = 2; x < width - 2; ++x)
            to[x] = value(x - 2, y) + value(x - 1, y) + value(x, y) + value(x + 1, y) + value(x + 2, y);
    });
    pool.parallel_for_each(height, [&](int y) {
        if (y < 2 || y >= height - 2) return;
        std::int32_t* const to = out.row(y);
        const std::int32_t *const a = across.row(y - 2), *const b = across.row(y - 1),
                                  *const c = across.row(y), *const d = across.row(y + 1),
                                  *const e = across.row(y + 2);
        for (int x = 2; x < width - 2; ++x) to[x] = a[x] + b[x] + c[x] + d[x] + e[x];
    });
    return out;
}

// The structure tensor's harmonic mean of eigenvalues, times 16; 0 within kBorder_px of the border.
RawVector<std::int64_t> strengths_of(const GreyPicture& picture, ThreadPool& pool) {
    const int width = picture.width, height = picture.height;
    Sums gx(width, height), gy(width, height);
    pool.parallel_for_each(height, [&](int y) {
        const bool is_border = y == 0 || y == height - 1;
        for (Sums* const to : {&gx, &gy})
            if (is_border)
                std::fill_n(to->row(y), width, 0);
            else
                to->row(y)[0] = to->row(y)[width - 1] = 0;
        if (is_border) return;
        const std::uint8_t *const above = picture.row(y - 1), *const at = picture.row(y),
                                  *const below = picture.row(y + 1);
        for (int x = 1; x < width - 1; ++x) {
            gx.row(y)[x] = at[x + 1] - at[x - 1];
            gy.row(y)[x] = below[x] - above[x];
        }
    });
    const auto product = [&](const Sums& a, const Sums& b) {
        return box_sums(width, height, pool, [&](int x, int y) { return a.row(y)[x] * b.row(y)[x]; });
    };
    const Sums xx = product(gx, gx), yy = product(gy, gy), xy = product(gx, gy);
    RawVector<std::int64_t> strengths(picture.values.size());
    pool.parallel_for_each(height, [&](int y) {
        std::fill_n(strengths.data() + static_cast<std::size_t>(y) * width, width, 0);
        if (y < kBorder_px || y >= height - kBorder_px) return;
        for (int x = kBorder_px; x < width - kBorder_px; ++x) {
            const std::int64_t a = xx.row(y)[x], b = yy.row(y)[x], c = xy.row(y)[x];
            strengths[static_cast<std::size_t>(y) * width + x] =
                16 * (a * b - c * c) / std::max<std::int64_t>(1, a + b);
        }
    });
    return strengths;
}

struct Peak {
    std::int64_t strength = 0;
    int x = 0, y = 0;
};

// True if no pixel within kApart is stronger, nor an equal one before it.
bool is_peak(const RawVector<std::int64_t>& strengths, int width, int x, int y) {
    const std::int64_t own = strengths[static_cast<std::size_t>(y) * width + x];
    if (own <= kLeastStrength) return false;
    for (int j = -kApart; j <= kApart; ++j)
        for (int i = -kApart; i <= kApart; ++i) {
            const std::int64_t other = strengths[static_cast<std::size_t>(y + j) * width + x + i];
            if (other > own || (other == own && (j < 0 || (j == 0 && i < 0)))) return false;
        }
    return true;
}

struct BoxPair {
    int ax = 0, ay = 0, bx = 0, by = 0;
};

// Returns 256 pairs of box centres, dense in the middle, by a linear congruential generator.
constexpr std::array<BoxPair, 256> box_pairs() {
    std::uint32_t state = 12345;
    const auto number = [&] {
        int sum = 0;
        for (int i = 0; i < 3; ++i) {
            state = (state * 1103515245u + 12345u) & 0x7fffffffu;
            sum += static_cast<int>((state >> 16) % 11) - 5;
        }
        return std::clamp(sum, -13, 13);
    };
    std::array<BoxPair, 256> pairs{};
    for (BoxPair& pair : pairs) {
        pair.ax = number();
        pair.ay = number();
        pair.bx = number();
        pair.by = number();
    }
    return pairs;
}

Descriptor describe(const Sums& boxes, int x, int y) {
    static constexpr std::array<BoxPair, 256> pairs = box_pairs();
    Descriptor bits{};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const BoxPair& p = pairs[i];
        const bool is_lighter = boxes.row(y + p.ay)[x + p.ax] > boxes.row(y + p.by)[x + p.bx];
        bits[i / 64] |= static_cast<std::uint64_t>(is_lighter) << (i % 64);
    }
    return bits;
}

constexpr int kLevels = 3;
constexpr int kLeastSide = 100;     // px of the smallest picture looked at
constexpr int kMostCorners = 3000;  // of a picture
constexpr int kAreaOfCorner = 100;  // px: small pictures have fewer corners
constexpr int kMostDifferent = 80;  // bits of 256
constexpr int kLead_percent = 80;   // of the distance of the second best
constexpr int kSamePlace = 3;       // px: the second best lies farther than this from the best
constexpr int kPatch = 7;           // px on each side of a patch's middle
constexpr int kRefined_px = 2;      // px that a match is moved when it is refined
constexpr int kPatchPixels = (2 * kPatch + 1) * (2 * kPatch + 1);
constexpr int kPlaces = 2 * kRefined_px + 1;

struct Candidate {
    int index = -1;  // of a right corner; -1 = none
    int bits = 0;
};

// Returns the right corner that describes a left one clearly best.
Candidate best_of(const Corner& corner, const std::vector<Corner>& others, std::vector<int>& distances) {
    Candidate best{-1, kMostDifferent};
    for (std::size_t j = 0; j < others.size(); ++j) {
        distances[j] = hamming_distance(corner.descriptor, others[j].descriptor);
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
        const int bits = hamming_distance(corners[i].descriptor, right.descriptor);
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
    if (!fits(left, a.x, a.y, kPatch) || !fits(right, b.x, b.y, kPatch + kRefined_px)) return std::nullopt;
    std::array<std::array<std::int64_t, kPlaces>, kPlaces> costs{};
    int best_x = 0, best_y = 0;
    for (int j = 0; j < kPlaces; ++j)
        for (int i = 0; i < kPlaces; ++i) {
            costs[j][i] = difference(left, a.x, a.y, right, b.x + i - kRefined_px, b.y + j - kRefined_px);
            if (costs[j][i] < costs[best_y][best_x]) {
                best_x = i;
                best_y = j;
            }
        }
    if (best_x == 0 || best_y == 0 || best_x == kPlaces - 1 || best_y == kPlaces - 1) return std::nullopt;
    const std::int64_t least = costs[best_y][best_x];
    const int part_x = least_place(costs[best_y][best_x - 1], least, costs[best_y][best_x + 1]),
              part_y = least_place(costs[best_y - 1][best_x], least, costs[best_y + 1][best_x]);
    return Point{b.x + best_x - kRefined_px + part_x / 64.0, b.y + best_y - kRefined_px + part_y / 64.0};
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

std::vector<Corner> find_corners(const GreyPicture& picture, int count, ThreadPool& pool) {
    const int width = picture.width, height = picture.height;
    if (std::min(width, height) <= 2 * kBorder_px) return {};
    const RawVector<std::int64_t> strengths = strengths_of(picture, pool);
    std::vector<std::vector<Peak>> cells(std::size_t{kCells} * kCells);
    pool.parallel_for_each(kCells, [&](int row) {
        const auto begin_of = [&](int r) { return (r * height + kCells - 1) / kCells; };
        for (int y = std::max(kBorder_px, begin_of(row));
             y < std::min(height - kBorder_px, begin_of(row + 1)); ++y)
            for (int x = kBorder_px; x < width - kBorder_px; ++x)
                if (is_peak(strengths, width, x, y))
                    cells[static_cast<std::size_t>(row) * kCells + x * kCells / width].push_back(
                        {strengths[static_cast<std::size_t>(y) * width + x], x, y});
    });
    const std::size_t most = static_cast<std::size_t>(count) / cells.size() + 1;
    std::vector<Corner> corners;
    for (std::vector<Peak>& cell : cells) {
        std::stable_sort(cell.begin(), cell.end(),
                         [](const Peak& a, const Peak& b) { return a.strength > b.strength; });
        if (cell.size() > most) cell.resize(most);
        for (const Peak& c : cell) corners.push_back({c.x, c.y});
    }
    const Sums boxes = box_sums(width, height, pool, [&](int x, int y) { return picture.row(y)[x]; });
    pool.parallel_for_each(corners.size(), [&](std::size_t i) {
        corners[i].descriptor = describe(boxes, corners[i].x, corners[i].y);
    });
    return corners;
}

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

std::vector<std::size_t> supported_by_neighbours(const std::vector<Match>& matches,
                                                 const std::vector<Point>& shifts) {
    std::vector<std::size_t> order(matches.size());  // by column, so that few are looked at
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return matches[a].left.x < matches[b].left.x; });
    std::vector<std::size_t> out;
    std::vector<std::pair<double, std::size_t>> nearest;  // a heap of squared distances
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
        const std::size_t i = order[rank];
        const auto column = [&](std::size_t other) { return matches[order[other]].left.x; };
        nearest.clear();
        for (std::size_t before = rank, behind = rank + 1; before > 0 || behind < order.size();) {
            const bool is_before =
                behind == order.size() ||
                (before > 0 && column(rank) - column(before - 1) <= column(behind) - column(rank));
            const std::size_t j = order[is_before ? --before : behind++];
            const double x = matches[j].left.x - matches[i].left.x, y = matches[j].left.y - matches[i].left.y;
            if (nearest.size() == kNeighbours && x * x > nearest.front().first) break;
            nearest.emplace_back(x * x + y * y, j);
            std::push_heap(nearest.begin(), nearest.end());
            if (nearest.size() <= kNeighbours) continue;
            std::pop_heap(nearest.begin(), nearest.end());
            nearest.pop_back();
        }
        const auto agrees = [&](const std::pair<double, std::size_t>& other) {
            const double x = shifts[other.second].x - shifts[i].x, y = shifts[other.second].y - shifts[i].y;
            return std::sqrt(x * x + y * y) < kSupport_px + kSupportSlope * std::sqrt(other.first);
        };
        if (static_cast<std::size_t>(std::count_if(nearest.begin(), nearest.end(), agrees)) >= kSupporting)
            out.push_back(i);
    }
    return out;
}

}  // namespace hexrelief::alignment
