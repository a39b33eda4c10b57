#include "pipeline/stages/by_colour/rims.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/color_difference.h"
#include "pipeline/data/four_neighbours.h"

namespace hexrelief::stages {
namespace {

constexpr int kNearShare = 120, kFarShare = 450;      // of the longer side: the band on both sides of a step
constexpr float kHighShare = 225, kLeastHigh_px = 2;  // a step: of the longer side; at least
constexpr float kSmooth_px = 1.0001f;
constexpr int kAcross = 24;  // steps of colour that a path across the map's own step costs: a bare rim stays
constexpr int kVote = 1 << 20;  // of the pixel itself
constexpr int kVotes = 3;       // strides of a quarter of the band, to each side

using Pixels = std::vector<std::uint32_t>;
enum Side : std::uint8_t { kNoSide, kNearSide, kFarSide };

class Rims {
  public:
    Rims(DisparityMap& map, const Image& left) : map_(map), left_(left), band_(map.values.size(), kNoSide) {
        const int longer = std::max(map.width, map.height);
        near_px_ = std::max(2, longer / kNearShare);
        far_px_ = std::max(1, longer / kFarShare);
        step_px_ = std::max(kLeastHigh_px, static_cast<float>(longer) / kHighShare);
    }

    void settle(ThreadPool& pool) {
        find_band();
        keep_narrow();
        lead();
        vote(pool);
        give();
    }

  private:
    float at(std::size_t i) const { return map_.values[i]; }
    template <class Take>
    void for_neighbours(std::size_t i, const Take& take) const {
        for_four_neighbours(i, map_.width, map_.height, [&](std::size_t j) {
            if (DisparityMap::known(at(j))) take(static_cast<std::uint32_t>(j));
        });
    }
    // Lets pixels grow by one a round: take(from, to) says whether a neighbour is added.
    template <class Take>
    void grow(Pixels front, int rounds, const Take& take) const {
        for (Pixels next; rounds > 0 && !front.empty(); --rounds, front.swap(next), next.clear())
            for (const std::uint32_t i : front)
                for_neighbours(i, [&](std::uint32_t j) {
                    if (take(i, j)) next.push_back(j);
                });
    }

    void find_band() {
        Pixels near, far;
        const auto width = static_cast<std::size_t>(map_.width), count = map_.values.size();
        const auto step_between = [&](std::size_t i, std::size_t j) {
            if (!(std::abs(at(i) - at(j)) > step_px_) || !DisparityMap::known(std::max(at(i), at(j)))) return;
            near.push_back(static_cast<std::uint32_t>(at(i) > at(j) ? i : j));
            far.push_back(static_cast<std::uint32_t>(at(i) > at(j) ? j : i));
        };
        for (std::size_t row = 0; row < count; row += width)
            for (std::size_t i = row; i < row + width; ++i) {
                if (i + 1 < row + width) step_between(i, i + 1);
                if (i + width < count) step_between(i, i + width);
            }
        const auto add = [&](const Pixels& first, Side side, int reach_px) {
            for (const std::uint32_t i : first) {
                if (band_[i] == kNoSide) open_.push_back(i);
                band_[i] = side;
            }
            grow(first, reach_px - 1, [&](std::uint32_t i, std::uint32_t j) {
                if (band_[j] != kNoSide || std::abs(at(j) - at(i)) > step_px_) return false;
                band_[j] = side;
                open_.push_back(j);
                return true;
            });
        };
        add(far, kFarSide, far_px_);
        add(near, kNearSide, near_px_);
    }

    // Takes out of the band narrow near things, to which every way from the surfaces beside it climbs, and
    // pixels with no surface on one of the sides.
    void keep_narrow() {
        std::vector<std::uint8_t> is_led(band_.size());
        const auto lead_to = [&](std::uint32_t i, std::uint32_t j) {
            if (band_[j] == kNoSide || is_led[j] || at(j) - at(i) > step_px_) return false;
            is_led[j] = 1;
            return true;
        };
        Pixels front;
        for (const std::uint32_t j : open_)
            for_neighbours(j, [&](std::uint32_t i) {
                if (band_[i] == kNoSide && lead_to(i, j)) front.push_back(j);
            });
        grow(front, near_px_ + near_px_ / 2, lead_to);
        keep_if([&](std::uint32_t i) { return is_led[i] != 0; });
        std::vector<std::uint8_t> sides(band_.size());  // a bit for each side in reach
        for (const Side side : {kNearSide, kFarSide}) {
            const auto reach = [&](std::uint32_t, std::uint32_t j) {
                if (band_[j] == kNoSide || (sides[j] & side)) return false;
                sides[j] |= side;
                return true;
            };
            front.clear();
            for (const std::uint32_t i : open_)
                if (band_[i] == side)
                    for_surfaces_beside(i, [&](std::uint32_t j) {
                        if (reach(j, i)) front.push_back(i);
                    });
            grow(front, 2 * near_px_, reach);
        }
        keep_if([&](std::uint32_t i) { return sides[i] == (kNearSide | kFarSide); });
    }
    template <class IsKept>
    void keep_if(const IsKept& is_kept) {
        std::erase_if(open_, [&](std::uint32_t i) {
            if (!is_kept(i)) band_[i] = kNoSide;
            return !is_kept(i);
        });
    }

    // Calls take(j) for each pixel beside the band that the open pixel continues on its side.
    template <class Take>
    void for_surfaces_beside(std::uint32_t i, const Take& take) const {
        for_neighbours(i, [&](std::uint32_t j) {
            if (band_[j] != kNoSide) return;
            const float rise = at(j) - at(i);
            if (band_[i] == kNearSide ? rise > -step_px_ : rise < step_px_) take(j);
        });
    }

    // Finds side_: from which side the least steps of colour lead to each open pixel.
    void lead() {
        side_.assign(band_.size(), kNoSide);
        std::vector<std::vector<std::pair<std::uint32_t, Side>>> waiting;  // by what led there
        const auto wait = [&](std::size_t so_far, std::uint32_t i, std::uint32_t j, std::uint32_t led,
                              Side side) {
            const bool is_across = band_[i] != kNoSide && band_[j] != kNoSide && band_[i] != band_[j];
            const int step = color_difference(left_, i, j) * 3 / left_.channels + (is_across ? kAcross : 0);
            const std::size_t cost = so_far + 1 + static_cast<std::size_t>(step);
            if (waiting.size() <= cost) waiting.resize(cost + 1);
            waiting[cost].emplace_back(led, side);
        };
        for (const std::uint32_t i : open_)
            for_surfaces_beside(i, [&](std::uint32_t j) { wait(0, i, j, i, Side(band_[i])); });
        for (std::size_t cost = 0; cost < waiting.size(); ++cost)
            for (std::size_t next = 0; next < waiting[cost].size(); ++next) {
                const auto [i, side] = waiting[cost][next];
                if (side_[i] != kNoSide) continue;
                side_[i] = side;
                for_neighbours(i, [&](std::uint32_t j) {
                    if (band_[j] != kNoSide && side_[j] == kNoSide) wait(cost, i, j, j, side);
                });
            }
    }

    void vote(ThreadPool& pool) {
        // The surfaces beside the band vote, too: it is narrower on the far side.
        std::vector<std::uint8_t> votes = side_;
        Pixels front;
        for (const std::uint32_t i : open_)
            for_surfaces_beside(i, [&](std::uint32_t j) {
                if (votes[j] != kNoSide) return;
                votes[j] = band_[i];  // of one that lies beside both sides, any
                front.push_back(j);
            });
        grow(front, near_px_, [&](std::uint32_t i, std::uint32_t j) {
            if (votes[j] != kNoSide || band_[j] != kNoSide || std::abs(at(j) - at(i)) > step_px_)
                return false;
            votes[j] = votes[i];
            return true;
        });
        const int stride = std::max(1, near_px_ / 4);
        const auto vote_at = [&](std::uint32_t i) {
            const int x = static_cast<int>(i) % map_.width, y = static_cast<int>(i) / map_.width;
            int lead = 0;
            for (int k = -kVotes; k <= kVotes; ++k)
                for (int m = -kVotes; m <= kVotes; ++m) {
                    const int u = x + m * stride, v = y + k * stride;
                    if (u < 0 || v < 0 || u >= map_.width || v >= map_.height) continue;
                    const std::uint8_t side = votes[static_cast<std::size_t>(v) * map_.width + u];
                    if (side == kNoSide) continue;
                    lead += (side == kNearSide ? kVote : -kVote) / (1 + k * k + m * m);
                }
            if (votes[i] != kNoSide && lead != 0) side_[i] = lead > 0 ? kNearSide : kFarSide;
        };
        pool.parallel_for_chunks(open_.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) vote_at(open_[i]);
        });
    }

    // Of a side's two disparities the one farther from the other side; `one` may be unknown.
    static float end_of(std::uint8_t side, float one, float other) {
        if (!DisparityMap::known(one)) return other;
        return side == kNearSide ? std::max(one, other) : std::min(one, other);
    }

    void give() {
        // What is settled continues its side, or has a disparity from there.
        std::vector<std::uint8_t> is_settled(band_.size());
        Pixels front;
        for (const std::uint32_t i : open_)
            for_surfaces_beside(i, [&](std::uint32_t j) {
                if (is_settled[i] || side_[i] != band_[i] || std::abs(at(i) - at(j)) > kSmooth_px) return;
                is_settled[i] = 1;
                front.push_back(i);
            });
        const int all = map_.width + map_.height;
        grow(front, all, [&](std::uint32_t i, std::uint32_t j) {
            if (is_settled[j] || side_[j] != side_[i] || std::abs(at(i) - at(j)) > kSmooth_px) return false;
            is_settled[j] = 1;
            front.push_back(j);
            return true;
        });
        const std::vector<float> before = map_.values;
        Pixels first = front;
        for (const std::uint32_t i : open_) {
            if (is_settled[i] || side_[i] != band_[i]) continue;
            float value = kUnknownDisparity;
            for_surfaces_beside(i, [&](std::uint32_t j) { value = end_of(band_[i], value, before[j]); });
            if (!DisparityMap::known(value)) continue;
            map_.values[i] = value;
            first.push_back(i);
        }
        for (const std::uint32_t i : first) is_settled[i] = 1;
        // Round by round, as the order of pixels must not matter.
        std::vector<float> given(band_.size(), kUnknownDisparity);
        for (Pixels next; !first.empty(); first.swap(next), next.clear()) {
            for (const std::uint32_t i : first)
                for_neighbours(i, [&](std::uint32_t j) {
                    if (is_settled[j] || side_[j] != side_[i] || band_[j] == kNoSide) return;
                    if (!DisparityMap::known(given[j])) next.push_back(j);
                    given[j] = end_of(side_[i], given[j], map_.values[i]);
                });
            for (const std::uint32_t j : next) {
                is_settled[j] = 1;
                map_.values[j] = given[j];
            }
        }
    }

    DisparityMap& map_;
    const Image& left_;
    int near_px_, far_px_;
    float step_px_;
    std::vector<std::uint8_t> band_, side_;  // of each pixel; what is not open has no side
    Pixels open_;
};

}  // namespace

DisparityMap with_rims_by_colour(DisparityMap map, const Image& left, int threads) {
    ThreadPool pool(threads);
    if (!map.values.empty() && !left.empty()) Rims(map, left).settle(pool);
    return map;
}

}  // namespace hexrelief::stages
