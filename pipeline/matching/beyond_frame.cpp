#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "pipeline/matching/matcher.h"
#include "pipeline/matching/refine/consistency_step.h"

namespace hexrelief::matching {
namespace {

// A steeper step ends a surface; a steeper slope would lead back into the right picture.
constexpr int kStep = kOnePixel;
constexpr int kLeast_px = 8;            // shorter surfaces say nothing about their slope
constexpr double kLeastHold = 1.0 / 4;  // least ratio of the two halves' slopes

// The sums of a line fit, scaled by the number of points.
struct Line {
    long long covariance = 0, variance = 0;

    void operator+=(const Line& other) {
        covariance += other.covariance;
        variance += other.variance;
    }
    double slope() const { return static_cast<double>(covariance) / static_cast<double>(variance); }
};

// A row's pixels beyond the frame, and the surface to their right: `length` pixels from column `first` on, 0
// if it says nothing; lines through the matches of its nearer and its farther half.
struct Strip {
    int first = 0, length = 0;
    Line near, far;
};

class Continuation {
  public:
    Continuation(MatchedMap& map, int min_px) : map_(map), min_px_(min_px), strips_(map.height) {
        for (int y = 0; y < map.height; ++y) strips_[y] = strip_of(y);
    }
    void fill_row(int y) {
        const Strip& strip = strips_[y];
        const auto [near, far] = slopes_at(y);
        const double least = std::min(std::abs(near), std::abs(far)),
                     largest = std::max(std::abs(near), std::abs(far));
        if (near * far <= 0 || least < kLeastHold * largest) return;
        // A slope that flattens towards the frame goes on flattening, until it is 0.
        const double bend = std::abs(near) < std::abs(far) ? (near - far) / (strip.length / 2.0) : 0;
        const double first_slope = std::abs(near) < std::abs(far) ? near : far;
        std::int16_t* const row = row_of(y);
        double disparity = row[strip.first];
        int before = row[strip.first];
        for (int x = strip.first - 1; x >= 0 && std::abs(row[x] - before) <= kStep; --x) {
            const int distance = strip.first - x;
            const double slope = first_slope + bend * (strip.length / 4.0 + distance - 0.5);
            if (distance <= strip.length && slope * first_slope > 0) disparity -= slope;
            before = row[x];
            row[x] = static_cast<std::int16_t>(std::clamp<long>(std::lround(disparity), 0, INT16_MAX));
        }
    }

  private:
    std::int16_t* row_of(int y) { return map_.disparities.data() + static_cast<std::size_t>(y) * map_.width; }
    const std::uint8_t* matched_row(int y) const {
        return map_.is_matched.data() + static_cast<std::size_t>(y) * map_.width;
    }

    Strip strip_of(int y) {
        const std::int16_t* const row = row_of(y);
        const std::uint8_t* const matched = matched_row(y);
        Strip strip;
        int& first = strip.first;
        while (first < map_.width && row[first] != kUnknown16 && !matched[first] &&
               step::beyond_left_edge(first, min_px_, row[first]))
            ++first;
        if (first == 0) return strip;
        int end = first;
        const int most = std::min(map_.width, 2 * first);
        while (end < most && row[end] != kUnknown16 && std::abs(row[end] - row[end - 1]) <= kStep) ++end;
        const int length = end - first, middle = first + length / 2;
        if (length < kLeast_px || 2 * std::count(matched + first, matched + middle, 1) < middle - first)
            return strip;
        strip.near = line_of(y, first, middle);
        strip.far = line_of(y, middle, end);
        if (strip.near.variance > 0 && strip.far.variance > 0) strip.length = length;
        return strip;
    }
    Line line_of(int y, int first, int end) {
        const std::int16_t* const row = row_of(y);
        long long n = 0, x = 0, d = 0, xx = 0, xd = 0;
        for (int i = 0; i < end - first; ++i) {
            if (!matched_row(y)[first + i]) continue;
            const long long here = row[first + i];
            ++n, x += i, d += here, xx += i * static_cast<long long>(i), xd += i * here;
        }
        return {n * xd - x * d, n * xx - x * x};
    }

    struct Slopes {
        double near = 0, far = 0;
    };
    // Returns the slopes over the rows of the same surface, as far up and down as the strip is wide.
    Slopes slopes_at(int y) {
        const Strip& own = strips_[y];
        if (own.length == 0) return {};
        Line near = own.near, far = own.far;
        for (const int step : {-1, 1}) {
            int before = row_of(y)[own.first];
            for (int other = y + step; std::abs(other - y) <= own.first; other += step) {
                if (other < 0 || other >= map_.height || strips_[other].length == 0) break;
                const int here = row_of(other)[strips_[other].first];
                if (std::abs(here - before) > kStep) break;
                before = here;
                near += strips_[other].near;
                far += strips_[other].far;
            }
        }
        return {near.slope(), far.slope()};
    }

    MatchedMap& map_;
    int min_px_;
    std::vector<Strip> strips_;
};

}  // namespace

void continue_beyond_frame(MatchedMap& map, int min_px) {
    Continuation continuation(map, min_px);
    for (int y = 0; y < map.height; ++y) continuation.fill_row(y);
}

}  // namespace hexrelief::matching
