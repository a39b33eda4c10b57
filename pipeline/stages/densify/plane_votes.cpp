#include "pipeline/stages/densify/plane_votes.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::stages {
namespace {

constexpr int kHalfStrides = 6;
constexpr float kStepPerStride = 10;  // a colour step of this much counts as a stride of distance
// Assumed distance, in strides, of the middle of a side without measurements.
constexpr float kMissing = 3;
constexpr int kFarColor = 255;  // assumed colour step of such a side

// The measurements of one side.
struct Side {
    float weight = 0, x = 0, y = 0;
    int step = kFarColor;

    void add(const PlaneAt& plane, int px, int py, float stride) {
        const auto dx = static_cast<float>(plane.x - px), dy = static_cast<float>(plane.y - py);
        const float fall = 1 + (dx * dx + dy * dy) / (stride * stride), w = 1 / (fall * fall);
        weight += w;
        x += w * dx;
        y += w * dy;
    }
    // Returns the divisor of the side's weight.
    float doubt(float stride) const {
        const float away = weight > 0 ? std::sqrt(x * x + y * y) / (weight * stride) : kMissing;
        const float both = (1 + away) * (1 + static_cast<float>(step) / kStepPerStride);
        return both * both * both;
    }
};

constexpr int kRadius = 3, kSide = 2 * kRadius + 1, kMost = kSide * kSide;
constexpr int kMostSurfaces = 6;
constexpr float kJoined_px = 1;    // the surface stage's own default
constexpr float kOtherColor = 40;  // larger colour steps have the least weight
constexpr float kLeastWeight = 0.02f;
constexpr float kMeasured = 3;    // factor for a window's pixel that was measured itself
constexpr float kSpread = 0.35f;  // weight (1 + kSpread r^2)^-2 at r strides

struct Vote {
    float d;
    float weight;  // weight by distance
    std::uint32_t plane;
};

struct Votes {
    Vote votes[kMost];
    int count = 0;
    float least = 0, most = 0;  // range of all d
};

struct Surface {
    float weight = 0, sum = 0;

    float mean() const { return sum / weight; }
};

class Window {
  public:
    explicit Window(int stride_px) : stride_px_(stride_px) {
        for (int j = -kRadius; j <= kRadius; ++j)
            for (int i = -kRadius; i <= kRadius; ++i) {
                const float fall = 1 + kSpread * static_cast<float>(i * i + j * j);
                weights_[(j + kRadius) * kSide + i + kRadius] = 1 / (fall * fall);
            }
    }
    Votes votes_at(int x, int y, const VoteInput& input) const {
        Votes found;
        float low = kUnknownDisparity, high = 0;
        for (int j = -kRadius; j <= kRadius; ++j)
            for (int i = -kRadius; i <= kRadius; ++i) {
                const int at_x = x + i * stride_px_, at_y = y + j * stride_px_;
                const std::uint32_t k = input.nearest.of(at_x, at_y);
                if (k == kNoMeasurement) continue;
                const PlaneAt& plane = input.planes[k];
                const bool is_measured = plane.x == at_x && plane.y == at_y;
                low = std::min(low, plane.d);
                high = std::max(high, plane.d);
                found.votes[found.count++] = {
                    plane.at(x, y),
                    weights_[(j + kRadius) * kSide + i + kRadius] * (is_measured ? kMeasured : 1), k};
            }
        found.least = high;
        found.most = low;
        for (int v = 0; v < found.count; ++v) {
            float& d = found.votes[v].d;
            d = std::clamp(d, low, high);
            found.least = std::min(found.least, d);
            found.most = std::max(found.most, d);
        }
        return found;
    }

  private:
    int stride_px_;
    float weights_[kMost];
};

float color_weight(int x, int y, const PlaneAt& plane, const Image& left) {
    const auto step = static_cast<float>(color_step(left.at(x, y), left.at(plane.x, plane.y), left.channels));
    const float alike = std::max(0.0f, 1 - step / kOtherColor);
    return alike * alike + kLeastWeight;
}

float mean_of(const Votes& votes) {
    Surface all;
    for (int v = 0; v < votes.count; ++v) {
        all.weight += votes.votes[v].weight;
        all.sum += votes.votes[v].weight * votes.votes[v].d;
    }
    return all.mean();
}

// Returns the mean of the chosen one of the two heaviest surfaces. Each vote joins the first surface whose
// mean so far is near enough.
float chosen_of(const Votes& votes, int x, int y, const VoteInput& input) {
    Surface surfaces[kMostSurfaces];
    int count = 0;
    for (int v = 0; v < votes.count; ++v) {
        const Vote& vote = votes.votes[v];
        const float weight =
            vote.weight * (input.left.empty() ? 1 : color_weight(x, y, input.planes[vote.plane], input.left));
        int s = 0;
        while (s < count &&
               std::abs(surfaces[s].sum - vote.d * surfaces[s].weight) > kJoined_px * surfaces[s].weight)
            ++s;
        if (s == kMostSurfaces) continue;
        count = std::max(count, s + 1);
        surfaces[s].weight += weight;
        surfaces[s].sum += weight * vote.d;
    }
    // Stable sort: ties go to the surface found first.
    std::stable_sort(surfaces, surfaces + count,
                     [](const Surface& a, const Surface& b) { return a.weight > b.weight; });
    if (count == 1) return surfaces[0].mean();
    const float d[2] = {surfaces[0].mean(), surfaces[1].mean()};
    if (std::abs(d[0] - d[1]) <= kJoined_px) return d[0];
    return surfaces[0].weight * side_odds(x, y, d, input.sides) >= surfaces[1].weight ? d[0] : d[1];
}

}  // namespace

Image smoothed(const Image& picture, ThreadPool& pool) {
    Image smooth = picture;
    const auto rows = static_cast<std::size_t>(picture.empty() ? 0 : picture.height);
    pool.parallel_for_chunks(rows, [&](int y) {
        for (int x = 0; x < picture.width; ++x) {
            const int xs[] = {std::max(x - 1, 0), x, std::min(x + 1, picture.width - 1)};
            const int ys[] = {std::max(y - 1, 0), y, std::min(y + 1, picture.height - 1)};
            for (int c = 0; c < picture.channels; ++c) {
                const auto row = [&](int v) {
                    return picture.at(xs[0], v)[c] + 2 * picture.at(x, v)[c] + picture.at(xs[2], v)[c];
                };
                smooth.at(x, y)[c] =
                    static_cast<std::uint8_t>((row(ys[0]) + 2 * row(y) + row(ys[2]) + 8) / 16);
            }
        }
    });
    return smooth;
}

float side_odds(int x, int y, const float (&d)[2], const SideInput& input) {
    Side sides[2];
    const Image& smooth = input.smooth;
    const auto stride = static_cast<float>(input.stride_px);
    const int half_px = (input.stride_px + 1) / 2;
    for (int j = -kHalfStrides; j <= kHalfStrides; ++j)
        for (int i = -kHalfStrides; i <= kHalfStrides; ++i) {
            const std::uint32_t k = input.around.of(x + i * half_px, y + j * half_px);
            if (k == kNoMeasurement) continue;
            const PlaneAt& plane = input.planes[k];
            const float here = plane.at(x, y);
            Side& side = sides[std::abs(here - d[0]) < std::abs(here - d[1]) ? 0 : 1];
            side.add(plane, x, y, stride);
            if (smooth.empty()) continue;
            side.step = std::min(side.step,
                                 color_step(smooth.at(x, y), smooth.at(plane.x, plane.y), smooth.channels));
        }
    return sides[1].doubt(stride) / sides[0].doubt(stride);
}

DisparityMap take_votes(const VoteInput& input, int stride_px, ThreadPool& pool) {
    DisparityMap dense = input.sparse;
    dense.origins.assign(dense.values.size(), PixelOrigin::unknown);
    const Window window(stride_px);
    pool.parallel_for_chunks(static_cast<std::size_t>(dense.height), [&](int y) {
        for (int x = 0; x < dense.width; ++x) {
            const std::size_t pixel = static_cast<std::size_t>(y) * dense.width + x;
            if (DisparityMap::known(dense.values[pixel])) {
                dense.origins[pixel] = PixelOrigin::matched;
                continue;
            }
            if (!input.filled[pixel]) continue;
            const Votes votes = window.votes_at(x, y, input);
            if (votes.count == 0) continue;
            const bool is_one = votes.most - votes.least <= kJoined_px;
            dense.values[pixel] = is_one ? mean_of(votes) : chosen_of(votes, x, y, input);
            dense.origins[pixel] = PixelOrigin::filled;
        }
    });
    return dense;
}

}  // namespace hexrelief::stages
