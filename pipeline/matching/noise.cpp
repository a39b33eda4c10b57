#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::matching {
namespace {

constexpr int kBlock_px = 16;
constexpr int kDarkest = 5, kLightest = 250;  // beyond these levels noise is cut off

// Returns the mean absolute second difference of a block's pixels along both axes, which slopes do not
// affect; negative if a tenth of the levels or more are next to black or white.
double roughness(const Image& image, int x0, int y0) {
    const int channels = image.channels, samples = kBlock_px * kBlock_px * channels;
    int sum = 0, cut = 0;
    for (int y = y0; y < y0 + kBlock_px; ++y) {
        const std::uint8_t *above = image.at(0, y - 1), *own = image.at(0, y), *below = image.at(0, y + 1);
        for (int i = x0 * channels; i < (x0 + kBlock_px) * channels; ++i) {
            const auto across = [&](const std::uint8_t* row) {
                return row[i - channels] - 2 * row[i] + row[i + channels];
            };
            sum += std::abs(across(above) - 2 * across(own) + across(below));
            cut += own[i] <= kDarkest || own[i] >= kLightest;
        }
    }
    return 10 * cut < samples ? static_cast<double>(sum) / samples : -1;
}

constexpr int kRadius_px = 2;
// 16 exp(-r^2 / (2 * 1.5^2)), indexed by the squared distance.
constexpr int kNearness[2 * kRadius_px * kRadius_px + 1] = {16, 13, 10, 0, 7, 5, 0, 0, 3};

// Replaces each pixel by the weighted mean of the pixels around it; weights grow with nearness
// and similarity of colour.
HEXRELIEF_SMALL_VECTORS void denoise_row(const ColorView& colors, int y, int other_color,
                                         std::uint8_t* __restrict out) {
    constexpr int kLanes = 32;
    const int channels = colors.channels, width = colors.planes[0].width;
    for (int x0 = 0; x0 < width; x0 += kLanes) {
        std::uint32_t sums[3][kLanes] = {}, weights[kLanes] = {};
        for (int j = -kRadius_px; j <= kRadius_px; ++j)
            for (int i = -kRadius_px; i <= kRadius_px; ++i) {
                int step[kLanes] = {};
                for (int c = 0; c < channels; ++c) {
                    const std::uint8_t* own = colors.planes[c].row(y) + x0;
                    const std::uint8_t* other = colors.planes[c].row(y + j) + x0 + i;
                    for (int k = 0; k < kLanes; ++k) step[k] = std::max(step[k], std::abs(own[k] - other[k]));
                }
                const int nearness = kNearness[i * i + j * j];
                for (int k = 0; k < kLanes; ++k) step[k] = nearness * std::max(0, other_color - step[k]);
                for (int c = 0; c < channels; ++c) {
                    const std::uint8_t* other = colors.planes[c].row(y + j) + x0 + i;
                    for (int k = 0; k < kLanes; ++k)
                        sums[c][k] += static_cast<std::uint32_t>(step[k]) * other[k];
                }
                for (int k = 0; k < kLanes; ++k) weights[k] += static_cast<std::uint32_t>(step[k]);
            }
        // The numbers are integers below 2^24: the quotient is the same on every processor.
        for (int c = 0; c < channels; ++c)
            for (int k = 0; k < std::min(kLanes, width - x0); ++k)
                out[(x0 + k) * channels + c] = static_cast<std::uint8_t>(
                    static_cast<float>(sums[c][k]) / static_cast<float>(weights[k]) + 0.5f);
    }
}

}  // namespace

double find_noise(const Image& image) {
    constexpr double kOfNormal = 0.20888568955258338;  // sqrt(pi / 2) / 6
    std::vector<double> blocks;
    for (int y = 1; y + kBlock_px < image.height; y += kBlock_px)
        for (int x = 1; x + kBlock_px < image.width; x += kBlock_px)
            if (const double rough = roughness(image, x, y); rough >= 0) blocks.push_back(rough);
    if (blocks.empty()) return 0;
    const auto tenth = blocks.begin() + static_cast<std::ptrdiff_t>(blocks.size() / 10);
    std::nth_element(blocks.begin(), tenth, blocks.end());
    return kOfNormal * *tenth;
}

void denoise(Image& image, double noise, int threads) {
    constexpr double kLeastNoise = 4, kAlike = 5;  // kAlike in standard deviations
    constexpr int kMostOther = 160;                // keeps sums below 2^24
    if (noise < kLeastNoise) return;
    const int other_color = std::min(kMostOther, static_cast<int>(std::lround(kAlike * noise)));
    ThreadPool pool(threads);
    const ColorPlanes colors = split_colors(image, Channels::as_they_are, pool);
    for_each_row(pool, image.height,
                 [&](int y) { denoise_row(view_of(colors), y, other_color, image.at(0, y)); });
}

}  // namespace hexrelief::matching
