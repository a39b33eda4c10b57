#include "pipeline/stages/densify/side_odds.h"

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

}  // namespace

Image smoothed(const Image& picture, ThreadPool& pool) {
    Image smooth = picture;
    const auto rows = static_cast<std::size_t>(picture.empty() ? 0 : picture.height);
    pool.parallel_for_chunks(rows, [&](std::size_t first, std::size_t end) {
        for (int y = static_cast<int>(first); y < static_cast<int>(end); ++y)
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

}  // namespace hexrelief::stages
