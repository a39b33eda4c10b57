#include "pipeline/job/pairs/working_size.h"

#include <algorithm>
#include <utility>

#include "pipeline/data/crop.h"
#include "pipeline/data/shrink.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::job {
namespace {

constexpr int kLeastSide_px = 16;  // matching needs as many columns

// Returns the image without the columns and rows that a reduction would leave over.
Image cut_for(int by, Image image) {
    const int width = image.width / by * by, height = image.height / by * by;
    if (image.width == width && image.height == height) return image;
    return cropped(image, {0, 0, width, height});
}

int floor_of(int value, int by) {
    return value >= 0 ? value / by : -((by - 1 - value) / by);
}

}  // namespace

int reduction_to(int working_px, int longest_px) {
    return working_px > 0 ? (longest_px + working_px - 1) / working_px : 1;
}

int reduction_of(const StereoPair& pair, int working_px) {
    const auto [shorter, longer] = std::minmax({pair.left.width, pair.left.height});
    return std::max(1, std::min(reduction_to(working_px, longer), shorter / kLeastSide_px));
}

ReducedPair reduced(StereoPair pair, int by, int threads) {
    ReducedPair result;
    const auto reduce = [by](Image& given, Image& picture, Image& view) {
        picture = cut_for(by, std::move(given));
        view = shrunk(picture, by);
    };
    auto right = start_work(threads, [&] { reduce(pair.right, result.pictures.right, result.views.right); });
    reduce(pair.left, result.pictures.left, result.views.left);
    right.get();
    return result;
}

readers::PixelMask reduced(const readers::PixelMask& mask, int by) {
    if (mask.empty()) return {};
    const auto width = static_cast<std::size_t>(mask.width / by),
               height = static_cast<std::size_t>(mask.height / by);
    readers::PixelMask small{mask.width / by, mask.height / by, std::vector<std::uint8_t>(width * height, 1)};
    for (std::size_t y = 0; y < height * by; ++y)
        for (std::size_t x = 0; x < width * by; ++x)
            small.kept[y / by * width + x / by] &= mask.kept[y * mask.width + x];
    return small;
}

stages::DisparityConfig for_reduced(stages::DisparityConfig config, int by) {
    const int end_px = config.min_disparity_px + config.num_disparities_px;
    config.min_disparity_px = floor_of(config.min_disparity_px, by);
    if (config.num_disparities_px > 0)
        config.num_disparities_px = -floor_of(-end_px, by) - config.min_disparity_px;
    config.farthest_px /= by;
    return config;
}

stages::DensityConfig for_reduced(stages::DensityConfig config, int by) {
    config.background_threshold_px /= by;
    return config;
}

}  // namespace hexrelief::job
