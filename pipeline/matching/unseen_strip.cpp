#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <queue>
#include <utility>
#include <vector>

#include "pipeline/matching/matcher.h"
#include "pipeline/matching/refine/frame_segment_step.h"
#include "pipeline/matching/refine/frame_segments.h"

namespace hexrelief::matching {
namespace {

constexpr int kCells = 450;                   // along the longer side
constexpr int kFraction = 16;                 // colours are in 1/16 level
constexpr int kColorRadius = 2;               // cells; texture is averaged out, so that it costs no path
constexpr int kStraight = 8, kDiagonal = 11;  // the cost of a cell's step per pixel, in 1/16 level
// The cost of a step in the map as it is, in levels per px. That a near surface reaches over a farther one
// costs more than the opposite.
constexpr int kFartherCost = 6, kNearerCost = 4;
constexpr double kJump_px = 1.5;  // of neighbouring pixels; cells of f px: 0.75 f, if more
constexpr int kScales = 3;
constexpr int kLeastRadius = 16;                // of the widest window, in cells
constexpr double kFlat = 0.5 * kOnePixel;       // largest RMS of a plane
constexpr double kLeastShare = 0.2;             // of a window that is matched
constexpr double kMostError = 1.5 * kOnePixel;  // that a bend may cause at the end of a plane

// In each row the number of pixels before the first match inside the right picture; 0 if there is none.
std::vector<int> strip_widths(const MatchedMap& map, int min_px) {
    std::vector<int> widths(map.height, 0);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * map.width + x;
            if (!map.is_matched[i] || map.disparities[i] > (x - min_px) * kOnePixel) continue;
            widths[y] = x;
            break;
        }
    return widths;
}

// Sums of several values over rectangles of cells.
template <std::size_t kValues>
class AreaSums {
  public:
    using Values = std::array<std::int64_t, kValues>;

    // values(x, y): those of a cell.
    template <typename Function>
    AreaSums(int columns, int rows, const Function& values)
        : stride_(columns + 1), sums_(static_cast<std::size_t>(stride_) * (rows + 1), Values{}) {
        for (int y = 0; y < rows; ++y) {
            Values of_row{};
            for (int x = 0; x < columns; ++x) {
                const Values here = values(x, y);
                for (std::size_t k = 0; k < kValues; ++k) {
                    of_row[k] += here[k];
                    at(x + 1, y + 1)[k] = at(x + 1, y)[k] + of_row[k];
                }
            }
        }
    }
    Values sum(int x0, int y0, int x1, int y1) const {
        Values sum = at(x1, y1);
        for (std::size_t k = 0; k < kValues; ++k) sum[k] += at(x0, y0)[k] - at(x0, y1)[k] - at(x1, y0)[k];
        return sum;
    }

  private:
    const Values& at(int x, int y) const { return sums_[static_cast<std::size_t>(y) * stride_ + x]; }
    Values& at(int x, int y) { return sums_[static_cast<std::size_t>(y) * stride_ + x]; }

    int stride_;
    std::vector<Values> sums_;
};

// The left part of the picture: four times the typical strip, and a little more. Disparities are those of the
// cells' middle pixels, in 1/16 px above the range's least.
struct Cells {
    int cell_px, columns, rows, typical_strip;
    std::vector<std::array<int, 3>> colors = {};
    std::vector<int> disparities = {};
    std::vector<std::uint8_t> is_matched = {}, is_seed = {};

    std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * columns + x; }
    int middle(int cell) const { return cell * cell_px + cell_px / 2; }
};

Cells size_of(const MatchedMap& map, const std::vector<int>& widths) {
    const auto [shorter, longer] = std::minmax(map.width, map.height);
    const int cell_px = std::clamp((longer + kCells / 2) / kCells, 1, shorter);
    Cells cells{cell_px, map.width / cell_px, map.height / cell_px, 0};
    std::vector<int> strips;
    for (int y = 0; y < cells.rows; ++y) strips.push_back(widths[cells.middle(y)] / cell_px);
    const auto middle = strips.begin() + cells.rows / 2;
    std::nth_element(strips.begin(), middle, strips.end());
    cells.typical_strip = *middle;
    cells.columns = std::min(cells.columns, 4 * cells.typical_strip + kLeastRadius);
    return cells;
}

void put_colors(Cells& cells, const Image& left) {
    const AreaSums<3> sums(cells.columns, cells.rows, [&](int x, int y) {
        std::array<std::int64_t, 3> sum{};
        for (int j = 0; j < cells.cell_px; ++j)
            for (int i = 0; i < cells.cell_px; ++i) {
                const std::uint8_t* pixel = left.at(x * cells.cell_px + i, y * cells.cell_px + j);
                for (int c = 0; c < 3; ++c) sum[c] += pixel[std::min(c, left.channels - 1)];
            }
        return sum;
    });
    for (int y = 0; y < cells.rows; ++y)
        for (int x = 0; x < cells.columns; ++x) {
            const int x0 = std::max(0, x - kColorRadius), x1 = std::min(cells.columns, x + kColorRadius + 1);
            const int y0 = std::max(0, y - kColorRadius), y1 = std::min(cells.rows, y + kColorRadius + 1);
            const int pixels = (x1 - x0) * (y1 - y0) * cells.cell_px * cells.cell_px;
            std::array<std::int64_t, 3> sum = sums.sum(x0, y0, x1, y1);
            for (std::int64_t& channel : sum) channel = channel * kFraction / pixels;
            cells.colors.push_back(
                {static_cast<int>(sum[0]), static_cast<int>(sum[1]), static_cast<int>(sum[2])});
        }
}

// Seeds are matched cells right of the strip, with no jump in the 3x3 cells around them.
void put_disparities(Cells& cells, const MatchedMap& map, const std::vector<int>& widths) {
    const std::size_t count = static_cast<std::size_t>(cells.columns) * cells.rows;
    cells.is_matched.resize(count);
    cells.is_seed.resize(count);
    for (int y = 0; y < cells.rows; ++y)
        for (int x = 0; x < cells.columns; ++x) {
            const int px = cells.middle(x), py = cells.middle(y);
            const std::size_t at = static_cast<std::size_t>(py) * map.width + px;
            cells.disparities.push_back(map.disparities[at]);
            cells.is_matched[cells.index(x, y)] = map.is_matched[at];
            cells.is_seed[cells.index(x, y)] = map.is_matched[at] && px >= widths[py];
        }
    const double jump_px = kJump_px * std::max(1.0, 0.75 * cells.cell_px);
    const auto end_seeds = [&](int x, int y, int dx, int dy) {
        if (x + dx >= cells.columns || y + dy >= cells.rows) return;
        const int step =
            cells.disparities[cells.index(x, y)] - cells.disparities[cells.index(x + dx, y + dy)];
        if (std::abs(step) <= jump_px * kOnePixel) return;
        for (int j = std::max(0, y - 1); j <= std::min(cells.rows - 1, y + dy + 1); ++j)
            for (int i = std::max(0, x - 1); i <= std::min(cells.columns - 1, x + dx + 1); ++i)
                cells.is_seed[cells.index(i, j)] = 0;
    };
    for (int y = 0; y < cells.rows; ++y)
        for (int x = 0; x < cells.columns; ++x) {
            end_seeds(x, y, 1, 0);
            end_seeds(x, y, 0, 1);
        }
}

// For each cell the seed at the end of its cheapest path (Dijkstra's algorithm); -1 if there is none.
std::vector<int> nearest_seeds(const Cells& cells) {
    constexpr std::uint64_t kFar = UINT64_MAX;
    std::vector<int> seeds(cells.is_seed.size(), -1);
    std::vector<std::uint64_t> costs(seeds.size(), kFar);
    // A path's cost, and its cell: of equal costs the first cell's path goes on first.
    using Path = std::pair<std::uint64_t, int>;
    std::priority_queue<Path, std::vector<Path>, std::greater<>> paths;
    const auto begin_at = [&](int x, int y) {
        const std::size_t i = cells.index(x, y);
        if (!cells.is_seed[i]) return;
        seeds[i] = static_cast<int>(i);
        costs[i] = 0;
        // Only the outermost seeds can lead on.
        const int x0 = std::max(0, x - 1), x1 = std::min(cells.columns - 1, x + 1);
        for (int j = std::max(0, y - 1); j <= std::min(cells.rows - 1, y + 1); ++j)
            for (int k = x0; k <= x1; ++k)
                if (!cells.is_seed[cells.index(k, j)]) return paths.emplace(0, static_cast<int>(i)), void();
    };
    for (int y = 0; y < cells.rows; ++y)
        for (int x = 0; x < cells.columns; ++x) begin_at(x, y);
    while (!paths.empty()) {
        const auto [cost, cell] = paths.top();
        paths.pop();
        if (cost > costs[cell]) continue;
        const int x = cell % cells.columns, y = cell / cells.columns;
        for (int j = std::max(0, y - 1); j <= std::min(cells.rows - 1, y + 1); ++j)
            for (int i = std::max(0, x - 1); i <= std::min(cells.columns - 1, x + 1); ++i) {
                const std::size_t next = cells.index(i, j);
                const int nearer = cells.disparities[next] - cells.disparities[cell];
                int step = cells.cell_px * (i != x && j != y ? kDiagonal : kStraight) +
                           (nearer > 0 ? kNearerCost * nearer : -kFartherCost * nearer);
                for (int c = 0; c < 3; ++c) step += std::abs(cells.colors[next][c] - cells.colors[cell][c]);
                if (cost + step >= costs[next]) continue;
                costs[next] = cost + step;
                seeds[next] = seeds[cell];
                paths.emplace(costs[next], static_cast<int>(next));
            }
    }
    return seeds;
}

struct Plane {
    double at = 0, slope_x = 0, slope_y = 0;  // 1/16 px, and that per cell
    double rms = 0, share = 0;
};

// Least-squares planes through the matched cells of square windows.
class Planes {
  public:
    explicit Planes(const Cells& cells)
        : columns_(cells.columns), rows_(cells.rows), sums_(columns_, rows_, [&](int column, int row) {
              const std::size_t i = cells.index(column, row);
              const std::int64_t x = column, y = row, d = cells.disparities[i];
              if (!cells.is_matched[i]) return AreaSums<10>::Values{};
              return AreaSums<10>::Values{1, x, y, d, x * x, y * y, x * y, x * d, y * d, d * d};
          }) {}

    Plane around(int x, int y, int radius) const {
        const int x0 = std::max(0, x - radius), x1 = std::min(columns_, x + radius + 1);
        const int y0 = std::max(0, y - radius), y1 = std::min(rows_, y + radius + 1);
        const AreaSums<10>::Values sums = sums_.sum(x0, y0, x1, y1);
        const auto count = static_cast<double>(sums[0]);
        if (count < 1) return {};
        const auto mean = [&](int k) { return static_cast<double>(sums[k]) / count; };
        const double mx = mean(1), my = mean(2), md = mean(3);
        constexpr double kEase = 0.05;  // a window of one column or row has no slope across
        const double cxx = mean(4) - mx * mx + kEase, cyy = mean(5) - my * my + kEase;
        const double cxy = mean(6) - mx * my, cxd = mean(7) - mx * md, cyd = mean(8) - my * md;
        const double det = cxx * cyy - cxy * cxy;
        const double a = (cxd * cyy - cyd * cxy) / det, b = (cyd * cxx - cxd * cxy) / det;
        const double rms = std::sqrt(std::max(0.0, mean(9) - md * md - a * cxd - b * cyd));
        const double across = 2 * radius + 1;
        return {md + a * (x - mx) + b * (y - my), a, b, rms, count / (across * across)};
    }

  private:
    int columns_, rows_;
    AreaSums<10> sums_;
};

// The plane on which a seed's surface goes on, and how far in cells.
struct Continuation {
    double at = 0, slope_x = 0, slope_y = 0, reach = 0;
};

// A surface that bends as d = q x^2 has a slope of q r over the r cells beside the strip and of q r / 2 over
// half of them. With the latter, and with b for the difference of the two, the plane is wrong by
// b (2 e^2 / r + e) after e cells.
Continuation continuation_of(const Cells& cells, const Planes& planes, int seed) {
    const int x = seed % cells.columns, y = seed / cells.columns;
    const double here = cells.disparities[seed];
    Continuation best{here};
    int radius = std::max(kLeastRadius, cells.typical_strip);
    for (int scale = 0; scale < kScales; ++scale, radius /= 2) {
        const Plane wide = planes.around(x, y, radius), near = planes.around(x, y, radius / 2);
        if (wide.rms > kFlat || wide.share < kLeastShare || std::abs(near.at - here) > kOnePixel) continue;
        constexpr double kLeastBend = 1e-5;
        const double bend =
            kLeastBend + std::sqrt((wide.slope_x - near.slope_x) * (wide.slope_x - near.slope_x) +
                                   (wide.slope_y - near.slope_y) * (wide.slope_y - near.slope_y));
        const double bent = radius / 4.0 * (std::sqrt(1 + 8 * kMostError / (radius * bend)) - 1);
        const double reach = std::min<double>(radius, bent);
        if (reach > best.reach) best = {near.at, near.slope_x, near.slope_y, reach};
    }
    return best;
}

// True for the pixels of segments that hardly match: they lie wholly beyond the frame, at least as near as
// they were filled (see frame_segments.h).
class BeyondFrame {
  public:
    BeyondFrame(const MatchedMap& map, const Image& left, int most_px) {
        const FrameSegments segments = find_frame_segments(left, most_px);
        grid_ = segments.grid;
        std::vector<std::int16_t> samples;
        for (int row = 0; row < grid_.rows; ++row)
            for (int column = 0; column < grid_.columns; ++column) {
                const int x = step::middle_of_cell(column, grid_.cell_px);
                const int y = step::middle_of_cell(row, grid_.cell_px);
                const std::size_t i = static_cast<std::size_t>(y) * map.width + x;
                samples.push_back(map.is_matched[i] ? kUnknown16 : map.disparities[i]);
            }
        least_ = least_disparities(segments, samples);
    }
    bool operator()(int x, int y) const {
        const int column = x / grid_.cell_px, row = y / grid_.cell_px;
        return column < grid_.columns && row < grid_.rows &&
               least_[static_cast<std::size_t>(row) * grid_.columns + column] != kUnknown16;
    }

  private:
    CellGrid grid_;
    std::vector<std::int16_t> least_;
};

}  // namespace

void continue_into_strip(MatchedMap& map, const Image& left, int min_px) {
    const std::vector<int> widths = strip_widths(map, min_px);
    if (*std::max_element(widths.begin(), widths.end()) == 0) return;
    int least = INT16_MAX, largest = 0;
    for (std::size_t i = 0; i < map.disparities.size(); ++i)
        if (map.is_matched[i]) {
            least = std::min<int>(least, map.disparities[i]);
            largest = std::max<int>(largest, map.disparities[i]);
        }
    Cells cells = size_of(map, widths);
    put_colors(cells, left);
    put_disparities(cells, map, widths);
    const std::vector<int> seeds = nearest_seeds(cells);
    const Planes planes(cells);
    const BeyondFrame is_beyond_frame(map, left, min_px + largest / kOnePixel + 1);
    std::vector<Continuation> continuations(seeds.size(), {0, 0, 0, -1});  // made when first needed
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < widths[y]; ++x) {
            const int column = x / cells.cell_px, row = std::min(y / cells.cell_px, cells.rows - 1);
            if (column >= cells.columns) break;
            const std::size_t i = static_cast<std::size_t>(y) * map.width + x;
            const int seed = seeds[cells.index(column, row)];
            if (seed < 0 || map.is_matched[i] || map.disparities[i] == kUnknown16) continue;
            Continuation& surface = continuations[seed];
            if (surface.reach < 0) surface = continuation_of(cells, planes, seed);
            const auto along = [&](int px, int cell) {
                const double distance = static_cast<double>(px - cells.middle(cell)) / cells.cell_px;
                return std::clamp(distance, -surface.reach, surface.reach);
            };
            const double d = surface.at + surface.slope_x * along(x, seed % cells.columns) +
                             surface.slope_y * along(y, seed / cells.columns);
            const int lowest = is_beyond_frame(x, y) ? std::max<int>(least, map.disparities[i]) : least;
            map.disparities[i] = static_cast<std::int16_t>(
                std::clamp(static_cast<int>(std::floor(d + 0.5)), lowest, std::max(lowest, largest)));
        }
}

}  // namespace hexrelief::matching
