#include "pipeline/stages/by_colour/bare_borders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/stages/by_colour/colours.h"

namespace hexrelief::stages {
namespace {

constexpr int kBorderRadius_px = 1,
              kSummed = (2 * kBorderRadius_px + 1) * (2 * kBorderRadius_px + 1);  // squares of colours
// Differences of these sums, the largest of the channels': between neighbours of a bare band; from where the
// flood came from; across a step in depth that is open; across a contour.
constexpr int kGradual = 3 * kSummed, kAlike = 12 * kSummed, kAlikeFarEnd = 80 * kSummed;
constexpr int kOpen = 8 * kSummed, kContour = 12 * kSummed;
constexpr int kReachShare = 40, kFarEndShare = 8, kStepShare = 450;  // of the longer side
constexpr float kLeastStep_px = 2;
constexpr int kThick_px = 4;                                        // of the nearer surface behind a contour
constexpr std::size_t kLeastRegion = 8, kFarEndRegionShare = 1000;  // pixels; of the picture
constexpr std::uint32_t kNone = ~std::uint32_t{0};

// One flood's limits.
struct Limits {
    int reach_px, alike;
    std::size_t least_region;
    float farthest = std::numeric_limits<float>::infinity();  // disparity of the surface that is given more
    bool stops_leaks = false;
};

class Borders {
  public:
    Borders(DisparityMap& map, const Image& left, ThreadPool& pool)
        : map_(map), sums_(colour_sums(left, kBorderRadius_px, pool)) {
        step_px_ = std::max(kLeastStep_px, static_cast<float>(std::max(map.width, map.height)) / kStepShare);
        source_.assign(map.values.size(), kNone);
        state_.assign(map.values.size(), State::other);
    }

    void give_back(Limits limits, Pictures pictures) {
        std::vector<float> values;
        for (const bool stops_leaks : {false, true}) {
            limits.stops_leaks = stops_leaks;
            flood(limits);
            judge(limits);
            if (pictures == Pictures::rectified) move_on();
            values.clear();
            for (const std::uint32_t i : given_) values.push_back(behind_all_given(i));
            for (std::size_t k = 0; k < given_.size(); ++k) map_.values[given_[k]] = values[k];
            for (const std::vector<std::uint32_t>* pixels : {&reached_, &given_})
                for (const std::uint32_t i : *pixels) {
                    source_[i] = kNone;
                    state_[i] = State::other;
                }
        }
    }

  private:
    enum class State : std::uint8_t { other, reached, seen, given };
    enum Side { leftwards, rightwards, above, below };
    static constexpr std::array<Side, 4> kSides{leftwards, rightwards, above, below};

    // Returns the pixel `steps` from another one on a side of it; kNone beyond the picture.
    std::uint32_t beside(std::uint32_t pixel, Side side, int steps) const {
        const int x = static_cast<int>(pixel) % map_.width, y = static_cast<int>(pixel) / map_.width;
        const int u = x + (side == rightwards ? steps : side == leftwards ? -steps : 0);
        const int v = y + (side == below ? steps : side == above ? -steps : 0);
        if (u < 0 || v < 0 || u >= map_.width || v >= map_.height) return kNone;
        return static_cast<std::uint32_t>(v) * map_.width + u;
    }
    int difference(std::uint32_t i, std::uint32_t j) const { return most_difference(sums_, i, j); }
    float far_of(std::uint32_t reached) const { return map_.values[source_[reached]]; }
    // Returns what a given pixel takes: its source's disparity; if that is given as well, its source's.
    float behind_all_given(std::uint32_t given) const {
        std::uint32_t source = source_[given];
        while (state_[source] == State::given) source = source_[source];
        return map_.values[source];
    }
    bool is_known(std::uint32_t i) const { return i != kNone && DisparityMap::known(map_.values[i]); }
    bool is_near(std::uint32_t i, float far) const { return is_known(i) && map_.values[i] - far > step_px_; }

    void enter(std::uint32_t near, std::uint32_t far, float farthest) {
        const float d = map_.values[far];
        if (!(map_.values[near] - d > step_px_) || d > farthest || !is_known(near)) return;
        if (difference(near, far) > kGradual) return;
        if (source_[near] == kNone)
            reached_.push_back(near);
        else if (offer(near, source_[near]) <= offer(near, far))
            return;
        source_[near] = far;
    }

    // Finds reached_, the pixels that the farther surface's colours lead to, and their source_ in it.
    void flood(const Limits& limits) {
        reached_.clear();
        const auto enter_between = [&](std::size_t i, std::size_t j) {
            if (!(std::abs(map_.values[i] - map_.values[j]) > step_px_)) return;
            enter(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), limits.farthest);
            enter(static_cast<std::uint32_t>(j), static_cast<std::uint32_t>(i), limits.farthest);
        };
        const auto width = static_cast<std::size_t>(map_.width);
        for (std::size_t row = 0; row < map_.values.size(); row += width)
            for (std::size_t i = row; i < row + width; ++i) {
                if (i + 1 < row + width) enter_between(i, i + 1);
                if (i + width < map_.values.size()) enter_between(i, i + width);
            }
        std::size_t begin = 0;
        for (int round = 1; round < limits.reach_px && begin < reached_.size(); ++round) {
            const std::size_t end = reached_.size();
            std::vector<Offer> offers;
            for (; begin < end; ++begin)
                for (const Side side : kSides) {
                    const std::uint32_t i = reached_[begin], j = beside(i, side, 1);
                    if (leads_on(i, j, limits.alike)) offers.push_back(offer(j, source_[i]));
                }
            take_best(offers, reached_);
        }
        if (limits.stops_leaks) drop_leaks(limits.alike);
        for (const std::uint32_t i : reached_) state_[i] = State::reached;
    }

    // A source that a pixel may get. The least offer to a pixel counts, whatever their order: that of the
    // most alike source; of these, the farthest one.
    struct Offer {
        std::uint32_t pixel;
        int difference;
        float disparity;
        std::uint32_t source;
        auto operator<=>(const Offer&) const = default;
    };
    Offer offer(std::uint32_t pixel, std::uint32_t source) const {
        return {pixel, difference(pixel, source), map_.values[source], source};
    }
    // Gives the pixels their sources, and adds them to `taken`.
    void take_best(std::vector<Offer>& offers, std::vector<std::uint32_t>& taken) {
        std::sort(offers.begin(), offers.end());
        for (std::size_t k = 0; k < offers.size(); ++k) {
            if (k > 0 && offers[k].pixel == offers[k - 1].pixel) continue;
            source_[offers[k].pixel] = offers[k].source;
            taken.push_back(offers[k].pixel);
        }
    }

    bool leads_on(std::uint32_t i, std::uint32_t j, int alike) const {
        return is_known(j) && source_[j] == kNone && is_near(j, far_of(i)) && difference(i, j) <= kGradual &&
               difference(source_[i], j) <= alike;
    }

    // Drops what was reached from the sources from which the flood would go on.
    void drop_leaks(int alike) {
        std::vector<std::uint32_t> leaks;
        for (const std::uint32_t i : reached_)
            for (const Side side : kSides)
                if (leads_on(i, beside(i, side, 1), alike)) leaks.push_back(source_[i]);
        std::sort(leaks.begin(), leaks.end());
        std::erase_if(reached_, [&](std::uint32_t i) {
            if (!std::binary_search(leaks.begin(), leaks.end(), source_[i])) return false;
            source_[i] = kNone;
            return true;
        });
    }

    // Finds given_, the regions of reached_ that have no contour at the step in depth, and one behind them.
    void judge(const Limits& limits) {
        given_.clear();
        std::vector<std::uint32_t> region;
        for (const std::uint32_t seed : reached_) {
            if (state_[seed] != State::reached) continue;
            region.assign(1, seed);
            state_[seed] = State::seen;
            std::size_t outer = 0, open = 0, inner = 0, closed = 0;
            for (std::size_t next = 0; next < region.size(); ++next)
                for (const Side side : kSides) {
                    const std::uint32_t i = region[next], j = beside(i, side, 1);
                    if (!is_known(j)) continue;
                    if (state_[j] == State::reached) {
                        state_[j] = State::seen;
                        region.push_back(j);
                    }
                    if (state_[j] != State::other) continue;
                    const int contour = difference_across(i, j, side);
                    if (map_.values[i] - map_.values[j] > step_px_) {
                        ++outer;
                        open += contour <= kOpen;
                    } else {
                        ++inner;
                        closed += contour >= kContour && is_thick(i, j, side);
                    }
                }
            if (region.size() < limits.least_region || 5 * open < 3 * outer || 5 * closed < 3 * inner ||
                inner == 0 || outer == 0)
                continue;
            for (const std::uint32_t i : region) state_[i] = State::given;
            given_.insert(given_.end(), region.begin(), region.end());
        }
    }

    // The difference of the colours a pixel before and behind the edge between two neighbours.
    int difference_across(std::uint32_t i, std::uint32_t j, Side side) const {
        const std::uint32_t before = beside(i, side, -1), behind = beside(j, side, 1);
        return difference(before == kNone ? i : before, behind == kNone ? j : behind);
    }

    // Whether the nearer surface goes on from j for some pixels, or to the picture's end.
    bool is_thick(std::uint32_t i, std::uint32_t j, Side side) const {
        for (int k = 0; k < kThick_px; ++k) {
            const std::uint32_t at = beside(j, side, k);
            if (at == kNone) return true;
            if (state_[at] != State::other || !is_near(at, far_of(i))) return false;
        }
        return true;
    }

    // Adds the pixels behind given_ that are more like its source than like what is two pixels farther on.
    void move_on() {
        std::vector<Offer> offers;
        for (const std::uint32_t i : given_)
            for (const Side side : kSides) {
                const std::uint32_t j = beside(i, side, 1), front = beside(i, side, 3);
                if (j == kNone || front == kNone || state_[j] == State::given ||
                    state_[front] == State::given)
                    continue;
                if (!is_near(j, far_of(i)) || !is_near(front, far_of(i))) continue;
                if (difference(source_[i], j) < difference(j, front)) offers.push_back(offer(j, source_[i]));
            }
        const std::size_t before = given_.size();
        take_best(offers, given_);
        for (std::size_t k = before; k < given_.size(); ++k) state_[given_[k]] = State::given;
    }

    DisparityMap& map_;
    cv::Mat sums_;
    float step_px_;
    std::vector<std::uint32_t> source_;  // of each pixel that was reached: the pixel across the step in depth
    std::vector<State> state_;
    std::vector<std::uint32_t> reached_, given_;
};

// Returns the largest disparity of the farthest tenth of what the map shows.
float far_end_of(const DisparityMap& map) {
    constexpr std::size_t kEvery = 7;  // pixels; a sample tells it
    std::vector<float> known = known_values(map, kEvery);
    if (known.empty()) return kUnknownDisparity;
    const float least = value_at_rank(known, (known.size() - 1) * 2 / 100),
                most = value_at_rank(known, (known.size() - 1) * 98 / 100);
    return least + 0.1f * (most - least);
}

}  // namespace

DisparityMap with_bare_borders_behind(DisparityMap map, const Image& left, Pictures pictures, int threads) {
    if (map.values.empty() || left.empty()) return map;
    const int longer = std::max(map.width, map.height);
    ThreadPool pool(threads);
    Borders borders(map, left, pool);
    borders.give_back({longer / kReachShare, kAlike, kLeastRegion}, pictures);
    if (pictures == Pictures::photographs)
        borders.give_back(
            {longer / kFarEndShare, kAlikeFarEnd, map.values.size() / kFarEndRegionShare, far_end_of(map)},
            pictures);
    return map;
}

}  // namespace hexrelief::stages
