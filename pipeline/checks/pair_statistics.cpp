#include "pipeline/checks/pair_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>

#include "pipeline/base/thread_pool.h"
#include "pipeline/checks/thresholds.h"

namespace hexrelief::checks {
namespace {

constexpr int kPoints = 240;
// Grey levels between a block's darkest and lightest pixels, ignoring the extreme tenths.
constexpr int kLeastSpread = 10;
constexpr int kBlock_px = 8;

// Returns the agreed disparities in px of the full pair, ascending.
std::vector<double> sorted_disparities(const stages::SmallMatch& match) {
    std::vector<double> known;
    for (const std::int16_t d : match.map.disparities)
        if (d != matching::kUnknown16)
            known.push_back(match.small.scale *
                            (match.min_px + d / static_cast<double>(matching::kOnePixel)));
    std::sort(known.begin(), known.end());
    return known;
}

constexpr int kLeastRun_px = 3;
// By how much a run of unmatched pixels may be longer or shorter than the step of the disparity across it.
constexpr double kOffShare = 0.35, kOff_px = 2;
constexpr int kReach_px = 1;     // of an edge from the end of the run
constexpr double kStronger = 3;  // than the contrast at the run's other end
// Least share of the runs with an edge at the right end of those with one at one end: it is 0.64 and more in
// left views with depth steps at 640 columns, 0.38 and less in right ones, if there are 100 runs or more.
constexpr double kLeastShare = 0.6;
// Edges that near each other are of one thing, which counts so many rows at most: the shadow that a lamp
// beside the camera throws looks like a strip that only one view shows, along the thing's whole height.
constexpr int kThing_px = 4, kThingRows = 16, kMostRows = 20;
constexpr int kLeastRows = 65;     // more than three things
constexpr double kMoreRows = 1.2;  // than at the other end: 1.4 and more in photographs, 1.1 of three shadows

// Returns the largest contrast of neighbours at the border between columns x and x + 1, or beside it.
int contrast_at(const Image& image, int x, int y) {
    int largest = 0;
    for (int at = std::max(0, x - kReach_px); at <= std::min(x + kReach_px, image.width - 2); ++at)
        for (int c = 0; c < image.channels; ++c)
            largest = std::max(largest, std::abs(image.at(at + 1, y)[c] - image.at(at, y)[c]));
    return largest;
}

// The edges at one end of the runs.
class Edges {
  public:
    explicit Edges(int width) : last_(width, -kThingRows - 1), rows_(width) {}

    // Adds one; they come row by row.
    void add(int x, int y) {
        int rows = 0;
        for (int at = std::max(0, x - kThing_px);
             at <= std::min(x + kThing_px, static_cast<int>(rows_.size()) - 1); ++at)
            if (y - last_[at] <= kThingRows) rows = std::max(rows, rows_[at]);
        last_[x] = y;
        rows_[x] = rows + 1;
        ++all_;
        of_things_ += rows < kMostRows;
    }
    // True if they are surely more than those at the other end.
    bool outnumber(const Edges& other) const {
        return of_things_ >= kLeastRows && of_things_ >= kMoreRows * other.of_things_ &&
               all_ >= kLeastShare * (all_ + other.all_);
    }

  private:
    std::vector<int> last_, rows_;  // of each column: the row of its last edge, and the rows of its thing
    int all_ = 0, of_things_ = 0;
};

struct EdgesAtEnds {
    Edges at_left, at_right;
};

EdgesAtEnds edges_of(const stages::SmallMatch& match) {
    const matching::MatchedMap& map = match.map;
    const Image& image = match.small.pair.left;
    EdgesAtEnds edges{Edges(map.width), Edges(map.width)};
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
                    if (left > kStronger * right) edges.at_left.add(before, y);
                    if (right > kStronger * left) edges.at_right.add(x, y);
                }
            }
            before = x;
        }
    }
    return edges;
}

// True if the block at (left, top), wholly inside the image, shows more than noise.
bool is_textured(const GreyImage& grey, int left, int top) {
    std::array<std::uint8_t, std::size_t{kBlock_px} * kBlock_px> block;
    for (int y = 0; y < kBlock_px; ++y)
        for (int x = 0; x < kBlock_px; ++x)
            block[static_cast<std::size_t>(y * kBlock_px + x)] = grey.at(left + x, top + y);
    return value_at_rank(block, block.size() * 9 / 10) - value_at_rank(block, block.size() / 10) >=
           kLeastSpread;
}

// Returns 1 for each block of the picture that shows more than noise, 0 for the others, row by row.
std::vector<std::uint8_t> textured_blocks(const Image& picture, int threads) {
    const GreyImage grey = grey_of(picture);
    const std::size_t columns = grey.width / kBlock_px;
    std::vector<std::uint8_t> textured(columns * (grey.height / kBlock_px));
    ThreadPool(threads).parallel_for_each(textured.size(), [&](std::size_t i) {
        textured[i] = is_textured(grey, static_cast<int>(i % columns) * kBlock_px,
                                  static_cast<int>(i / columns) * kBlock_px);
    });
    return textured;
}

}  // namespace

double agreed_share(const stages::SmallMatch& match, double seen_share) {
    const auto& is_matched = match.map.is_matched;
    const auto agreed = static_cast<double>(std::count(is_matched.begin(), is_matched.end(), 1));
    return std::min(1.0, agreed / std::max(1.0, seen_share * static_cast<double>(is_matched.size())));
}

double swapped_share(const stages::SmallMatch& match, double seen_share, int threads) {
    return agreed_share(stages::match_coarsely({match.small.pair.right, match.small.pair.left}, 0, threads),
                        seen_share);
}

double median_disparity_px(const stages::SmallMatch& match) {
    const std::vector<double> known = sorted_disparities(match);
    return known.empty() ? std::numeric_limits<double>::quiet_NaN() : known[known.size() / 2];
}

bool is_blank(const Image& image) {
    const auto& samples = image.pixels;
    const auto channels = static_cast<std::ptrdiff_t>(image.channels);
    return std::equal(samples.begin() + channels, samples.end(), samples.begin());
}

double textured_share(const Image& reduced, int threads) {
    const std::vector<std::uint8_t> blocks = textured_blocks(reduced, threads);
    if (blocks.empty()) return 1;
    return static_cast<double>(std::ranges::count(blocks, 1)) / static_cast<double>(blocks.size());
}

RowFit measure_rows(const StereoPair& pair, const stages::SmallMatch& coarse, int threads) {
    const GreyImage left = grey_of(pair.left), right = grey_of(pair.right);
    const double scale = coarse.small.scale;
    std::vector<PointSearch> searches;
    for (PointSearch point : find_points(left, kPoints)) {
        const int x = std::min(static_cast<int>(point.x / scale), coarse.map.width - 1);
        const int y = std::min(static_cast<int>(point.y / scale), coarse.map.height - 1);
        const int d = coarse.map.disparities[static_cast<std::size_t>(y) * coarse.map.width + x];
        if (d == matching::kUnknown16) continue;
        point.disparity_px = static_cast<int>(
            std::lround(scale * (coarse.min_px + d / static_cast<double>(matching::kOnePixel))));
        point.reach_px = point.row_reach_px = static_cast<int>(std::ceil(1.5 * scale)) + 2;
        searches.push_back(point);
    }
    return fit_rows(match_points(left, right, searches, threads), left.width, left.height);
}

CoarsePoints match_coarse_points(const stages::SmallMatch& coarse, int threads) {
    const double scale = coarse.small.scale;
    const GreyImage left = grey_of(coarse.small.pair.left), right = grey_of(coarse.small.pair.right);
    std::vector<PointSearch> searches = find_points(left, kPoints);
    for (PointSearch& search : searches) {
        search.reach_px = left.width / 2;
        search.row_reach_px = std::max(4, left.height / 8);
    }
    CoarsePoints points{match_points(left, right, searches, threads), {}};
    points.rows = fit_rows(points.matches, left.width, left.height);
    std::erase_if(points.matches, [&](const PointMatch& match) {
        return std::fabs(match.row_px - points.rows.at(match.x, match.y)) > kAgree_px;
    });
    points.rows.center_px *= scale;
    points.rows.largest_px *= scale;
    return points;
}

LowEnd measure_low_end(const std::vector<PointMatch>& matches, double scale, int min_px) {
    if (matches.empty()) return {};
    std::vector<double> disparities;
    for (const PointMatch& match : matches) disparities.push_back(scale * match.disparity_px);
    std::sort(disparities.begin(), disparities.end());
    const auto share_below = [&](double limit) {
        return static_cast<double>(std::lower_bound(disparities.begin(), disparities.end(), limit) -
                                   disparities.begin()) /
               static_cast<double>(disparities.size());
    };
    return {share_below(min_px - 0.5 * scale), share_below(-0.5 * scale),
            disparities[disparities.size() / 50]};
}

double share_at_low_end(const stages::SmallMatch& match) {
    int known = 0, low = 0;
    for (const std::int16_t d : match.map.disparities) {
        known += d != matching::kUnknown16;
        low += d != matching::kUnknown16 && d < matching::kOnePixel;
    }
    return known > 0 ? low / static_cast<double>(known) : 0;
}

double share_at_zero(const stages::SmallMatch& match) {
    int known = 0, zero = 0;
    for (const std::int16_t d : match.map.disparities) {
        known += d != matching::kUnknown16;
        zero += d != matching::kUnknown16 &&
                std::abs(match.min_px * matching::kOnePixel + d) < matching::kOnePixel;
    }
    return known > 0 ? zero / static_cast<double>(known) : 0;
}

double difference_over_slope(const StereoPair& pair) {
    const GreyImage left = grey_of(pair.left), right = grey_of(pair.right);
    long long difference = 0, slope = 0;
    for (int y = 0; y < left.height; ++y)
        for (int x = 0; x + 1 < left.width; ++x) {
            difference += std::abs(left.at(x, y) - right.at(x, y));
            slope += std::abs(left.at(x, y) - left.at(x + 1, y));
        }
    return difference / std::max(1.0, static_cast<double>(slope));
}

HighEnd measure_high_end(const stages::SmallMatch& coarse, int end_px) {
    const std::vector<double> known = sorted_disparities(coarse);
    if (known.empty()) return {};
    const auto beyond =
        known.end() - std::upper_bound(known.begin(), known.end(), end_px + 0.5 * coarse.small.scale);
    return {static_cast<double>(beyond) / static_cast<double>(known.size()),
            known[known.size() - 1 - known.size() / 200]};
}

double measure_support(const Image& left, const DisparityMap& map, const std::vector<std::uint8_t>& is_kept,
                       const std::vector<std::uint8_t>& is_seen, int threads) {
    const std::vector<std::uint8_t> blocks = textured_blocks(left, threads);
    const int columns = left.width / kBlock_px;
    long long textured = 0, agreed = 0;
    const auto count = [&](int x, int y) {
        const std::size_t row = static_cast<std::size_t>(y) * map.width, i = row + x;
        if (!is_kept.empty() && !is_kept[i]) return;
        if (const float right_x = static_cast<float>(x) - map.values[i]; DisparityMap::known(map.values[i])) {
            if (right_x < 0) return;
            const auto column = static_cast<std::size_t>(std::lround(right_x));
            if (!is_seen.empty() && (column >= static_cast<std::size_t>(map.width) || !is_seen[row + column]))
                return;
        }
        ++textured;
        agreed += map.origins[i] == PixelOrigin::matched;
    };
    for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
        if (!blocks[i]) continue;
        const int left_px = i % columns * kBlock_px, top_px = i / columns * kBlock_px;
        for (int y = top_px; y < top_px + kBlock_px; ++y)
            for (int x = left_px; x < left_px + kBlock_px; ++x) count(x, y);
    }
    return textured == 0 ? 0 : static_cast<double>(agreed) / static_cast<double>(textured);
}

const char* support_word(double support) {
    return support >= kGoodSupport ? "good" : is_hardly_supported(support) ? "hardly" : "partly";
}

bool is_hardly_supported(double support) {
    return support < kLeastSupport;
}

bool is_surely_left(const stages::SmallMatch& match) {
    const EdgesAtEnds edges = edges_of(match);
    return edges.at_right.outnumber(edges.at_left);
}

bool is_surely_right(const stages::SmallMatch& match) {
    const EdgesAtEnds edges = edges_of(match);
    return edges.at_left.outnumber(edges.at_right);
}

}  // namespace hexrelief::checks
