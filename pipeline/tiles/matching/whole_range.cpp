#include "pipeline/tiles/matching/whole_range.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/data/start_work.h"
#include "pipeline/job/steps.h"
#include "pipeline/stages/sgbm.h"
#include "pipeline/tiles/shrunk_picture.h"

namespace hexrelief::tiles {
namespace {

// Most pixels of the shrunk pair; the range is found in far fewer.
constexpr long long kShrunkPixels = 1 << 24;
constexpr int kLeastColumns = 16;

int shrunk_by(int width, int height) {
    int by = 1;
    const auto side = [&](int size) { return (size + by - 1) / by; };
    while (1LL * side(width) * side(height) > kShrunkPixels ||
           std::max(side(width), side(height)) > kLargestPairSide_px)
        ++by;
    return by;
}

StereoPair shrunk_pair(const PairWindows& pair, int by, int threads) {
    const mesh_tiles::MapRect whole{0, 0, pair.left.width(), pair.left.height()};
    auto right = start_work(threads, [&] { return shrunk_picture(pair.right, whole, by); });
    Image left = shrunk_picture(pair.left, whole, by);
    return {std::move(left), right.get()};
}

// Returns the number of disparities at full size for the range of the shrunk pair.
int num_disparities_of_whole(int shrunk_end_px, int by, const stages::DisparityConfig& config, int width) {
    const long long end = 1LL * by * shrunk_end_px;
    const int widest = std::min(
        width, stages::round_up_range(stages::kLargestRange_px - std::max(0, config.min_disparity_px)) - 16);
    return static_cast<int>(
        std::clamp<long long>(end - config.min_disparity_px, 1, std::max(kLeastColumns, widest)));
}

}  // namespace

stages::FoundRange find_range_of_whole(const PairWindows& pair, const Calibration& calibration,
                                       const stages::DisparityConfig& config, int threads, job::RunLog& log) {
    const int width = pair.left.width(), height = pair.left.height();
    const auto sizes_of = [](const readers::PictureWindows& picture) {
        return Image{picture.width(), picture.height(), picture.channels(), {}};
    };
    const StereoPair sizes{sizes_of(pair.left), sizes_of(pair.right)};
    stages::check_matchable(sizes, config);
    stages::FoundRange whole{config, stages::RangeOrigin::given};
    stages::DisparityConfig& ranged = whole.config;
    std::string how;
    const int by = shrunk_by(width, height);
    const bool is_narrow = width < kLeastColumns * by;  // and very high
    int shrunk_end_px = 0;
    if (!is_narrow) {
        stages::DisparityConfig shrunk = config;
        shrunk.min_disparity_px =
            static_cast<int>(std::floor(static_cast<double>(config.min_disparity_px) / by));
        shrunk.num_disparities_px = 0;
        stages::FoundRange small = stages::find_range(shrunk_pair(pair, by, threads), {}, shrunk, threads);
        shrunk_end_px = small.config.min_disparity_px + small.config.num_disparities_px;
        const PixelRect middle = stages::middle_of(width, height);
        const auto read = [&](const readers::PictureWindows& picture) {
            return picture.read(middle.x, middle.y, middle.width, middle.height);
        };
        whole.correction = stages::find_correction(small.coarse, read(pair.left), read(pair.right));
        if (std::isnan(ranged.farthest_px)) ranged.farthest_px = by * small.config.farthest_px;
        whole.coarse = std::move(small.coarse);
    }
    if (const int by_calibration = stages::num_disparities_by(calibration, config, width);
        by_calibration > 0) {
        whole.origin = stages::RangeOrigin::ndisp;
        ranged.num_disparities_px = by_calibration;
    } else if (config.num_disparities_px == 0) {
        whole.origin = stages::RangeOrigin::chosen;
        ranged.num_disparities_px =
            is_narrow ? width : num_disparities_of_whole(shrunk_end_px, by, config, width);
        if (by > 1 && !is_narrow) how = " at 1/" + std::to_string(by) + " of its size";
    }
    stages::check_matchable(sizes, ranged);
    stages::DisparityConfig rounded = ranged;
    rounded.num_disparities_px = stages::round_up_range(ranged.num_disparities_px);
    log.decide(job::range_text(rounded, whole.origin) + how);
    return whole;
}

}  // namespace hexrelief::tiles
