#include "pipeline/stages/by_colour/filled_rims.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "pipeline/data/color_difference.h"
#include "pipeline/data/four_neighbours.h"
#include "pipeline/stages/by_colour/colours.h"
#include "pipeline/stages/by_colour/grow_into.h"

namespace hexrelief::stages {
namespace {

constexpr int kFilledRimShare = 60;                         // of the longer side: the width
constexpr float kRimStepShare = 225, kLeastRimStep_px = 2;  // of the longer side: a step; at least
constexpr float kSettled_px = 0.01F;                        // no change that is larger: smooth
constexpr int kOverStep = 24;                               // steps of colour that the map's own step costs
constexpr int kRimRadius_px = 1, kRimSummed = 9;            // squares of colours, and their pixels
constexpr int kOpenRim = 8 * kRimSummed, kClosedRim = 12 * kRimSummed;  // their differences across a border

class FilledRims {
  public:
    FilledRims(DisparityMap& map, const Image& left, ThreadPool& pool)
        : map_(map),
          left_(left),
          pool_(pool),
          sums_(colour_sums(left, kRimRadius_px, pool)),
          state_(map.values.size()) {
        const int longer = std::max(map.width, map.height);
        reach_px_ = std::max(2, longer / kFilledRimShare);
        step_px_ = std::max(kLeastRimStep_px, static_cast<float>(longer) / kRimStepShare);
    }

    void join() {
        find_filled();
        lead();
        judge();
        const auto is_source = [&](std::size_t, float d, std::size_t i) {
            return state_[i] != State::of_near && map_.values[i] - d > step_px_;
        };
        grow_into(map_, joined_, is_source, [&](std::size_t i) { state_[i] = State::joined; });
        means_.resize(joined_.size());
        const int most = reach_px_ * reach_px_ / 4;  // rounds: as far as rims are wide
        for (int round = 0; round < most && smooth() > kSettled_px;) ++round;
    }

  private:
    enum class State : std::uint8_t { other, filled, of_far, of_near, joined };

    bool is_nearer(std::size_t i, std::size_t than) const {
        return map_.values[i] - map_.values[than] > step_px_;
    }
    template <class Take>
    void for_neighbours(std::size_t pixel, const Take& take) const {
        for_four_neighbours(pixel, map_.width, map_.height, [&](std::size_t i) {
            if (DisparityMap::known(map_.values[i])) take(i);
        });
    }

    void find_filled() {
        std::size_t begin = 0;
        const auto add = [&](std::size_t i) {
            if (state_[i] != State::other || map_.origins[i] != PixelOrigin::filled) return;
            state_[i] = State::filled;
            filled_.push_back(i);
        };
        for (std::size_t i = 0; i < state_.size(); ++i)
            if (DisparityMap::known(map_.values[i]))
                for_neighbours(i, [&](std::size_t j) {
                    if (is_nearer(j, i)) add(i);
                });
        for (int round = 1; round < reach_px_; ++round)
            for (const std::size_t end = filled_.size(); begin < end; ++begin) {
                const std::size_t i = filled_[begin];
                for_neighbours(i, [&](std::size_t j) {
                    if (!is_nearer(j, i)) add(j);
                });
            }
    }

    // Finds from which side the least steps of colour lead to each filled pixel.
    void lead() {
        std::vector<std::vector<std::pair<std::size_t, State>>> waiting;  // by what led there
        const auto wait = [&](std::size_t so_far, std::size_t from, std::size_t to, State side) {
            const int step = color_difference(left_, from, to) * 3 / left_.channels;
            const std::size_t cost = so_far + 1 + static_cast<std::size_t>(step);
            if (waiting.size() <= cost) waiting.resize(cost + 1);
            waiting[cost].emplace_back(to, side);
        };
        for (const std::size_t i : filled_)
            for_neighbours(i, [&](std::size_t j) {
                if (state_[j] != State::other) return;
                const bool is_near = is_nearer(j, i);
                wait(is_near ? kOverStep : 0, j, i, is_near ? State::of_near : State::of_far);
            });
        for (std::size_t cost = 0; cost < waiting.size(); ++cost)
            for (std::size_t next = 0; next < waiting[cost].size(); ++next) {
                const auto [i, side] = waiting[cost][next];
                if (state_[i] != State::filled) continue;
                state_[i] = side;
                for_neighbours(i, [&, led = i, from = side](std::size_t j) {
                    if (state_[j] == State::filled) wait(cost, led, j, from);
                });
            }
    }

    // Finds joined_, the regions that are open to the nearer surface, and end at contours.
    void judge() {
        std::vector<bool> is_seen(state_.size());
        for (const std::size_t seed : filled_) {
            if (state_[seed] != State::of_near || is_seen[seed]) continue;
            const std::size_t first = joined_.size();
            joined_.push_back(seed);
            is_seen[seed] = true;
            int near = 0, open = 0, far = 0, closed = 0;
            for (std::size_t next = first; next < joined_.size(); ++next) {
                const std::size_t i = joined_[next];
                for_neighbours(i, [&](std::size_t j) {
                    if (state_[j] == State::of_near) {
                        if (!is_seen[j]) joined_.push_back(j);
                        is_seen[j] = true;
                        return;
                    }
                    const int contour = most_difference(sums_, behind(j, i), behind(i, j));
                    (is_nearer(j, i) ? near : far) += 1;
                    (is_nearer(j, i) ? open += contour <= kOpenRim : closed += contour >= kClosedRim);
                });
            }
            const bool is_crumb = joined_.size() - first < static_cast<std::size_t>(reach_px_);
            if (!is_crumb && 2 * open > near && 2 * closed > far) continue;
            for (std::size_t k = first; k < joined_.size(); ++k) state_[joined_[k]] = State::of_far;
            joined_.resize(first);
        }
    }
    // Returns the pixel behind j, seen from its neighbour i; at the picture's end j.
    std::size_t behind(std::size_t i, std::size_t j) const {
        std::size_t found = j;
        for_neighbours(j, [&](std::size_t k) {
            if (k + i == 2 * j) found = k;
        });
        return found;
    }

    // The surfaces that grew into a region from several sides meet in steps.
    // Returns the largest change.
    float smooth() {
        pool_.parallel_for_chunks(joined_.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const std::size_t i = joined_[k];
                float sum = map_.values[i];
                int count = 1;
                for_neighbours(i, [&](std::size_t j) {
                    if (state_[j] != State::joined && (is_nearer(i, j) || is_nearer(j, i))) return;
                    sum += map_.values[j];
                    ++count;
                });
                means_[k] = sum / static_cast<float>(count);
            }
        });
        float largest = 0;
        for (std::size_t k = 0; k < joined_.size(); ++k) {
            float& d = map_.values[joined_[k]];
            largest = std::max(largest, std::abs(means_[k] - d));
            d = means_[k];
        }
        return largest;
    }

    DisparityMap& map_;
    const Image& left_;
    ThreadPool& pool_;
    cv::Mat sums_;
    int reach_px_;
    float step_px_;
    std::vector<State> state_;
    std::vector<std::size_t> filled_, joined_;
    std::vector<float> means_;
};

}  // namespace

DisparityMap with_filled_rims_joined(DisparityMap map, const Image& left, int threads) {
    if (map.origins.empty() || left.empty()) return map;
    ThreadPool pool(threads);
    FilledRims(map, left, pool).join();
    return map;
}

}  // namespace hexrelief::stages
