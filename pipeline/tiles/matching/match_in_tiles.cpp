#include "pipeline/tiles/matching/match_in_tiles.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <future>
#include <utility>
#include <vector>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/disparities.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/windows/map_writer.h"
#include "pipeline/stages/sgbm.h"

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
    const auto shrunk = [by](const readers::PictureWindows& picture) {
        return picture.read_shrunk(0, 0, picture.width(), picture.height(), by);
    };
    auto right = start_work(threads, [&] { return shrunk(pair.right); });
    Image left = shrunk(pair.left);
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

// Windows are aligned to this. Pictures with the largest range are halved five times, so all windows share
// the pixels of the halved pictures.
constexpr int kAligned_px = 32;
int aligned_below(int px) {
    return std::max(0, px / kAligned_px * kAligned_px);
}
int aligned_above(int px, int most) {
    return std::min((px + kAligned_px - 1) / kAligned_px * kAligned_px, most);
}

void check_request(const MatchRequest& request) {
    const auto refuse = [](const std::string& message) { throw Error(ErrorKind::usage, message); };
    if (request.config.disparity.method != stages::DisparityMethod::sgm)
        refuse("disparity.method: must be sgm; StereoSGBM would leave seams between tiles");
    const config::CalibrationConfig& calibration = request.config.input.calibration;
    files::check_overwrites({request.map},
                            {request.left, request.right, calibration.file, calibration.second_file});
    if (calibration.file.empty() && calibration.rectify == readers::Rectify::always)
        refuse("input.calibration.rectify: must not be always; tiles are matched in rectified pairs");
    if (calibration.file.empty()) return;
    const auto pair = readers::read_stereo_calibration({calibration.file, calibration.second_file, 0, 0},
                                                       calibration.rectify);
    if (pair && !(pair->is_rectified && calibration.rectify == readers::Rectify::automatic))
        throw Error(ErrorKind::input, calibration.file +
                                          ": tells of a pair that is to be rectified; tiles are matched in "
                                          "pairs that are rectified already");
}

Calibration camera_of(const MatchRequest& request, const readers::PictureWindows& left) {
    const job::ViewSize size{left.width(), left.height()};
    return job::resolve_calibration({request.config.input.calibration, size, size, nullptr, request.left})
        .calibration;
}

class TiledMatcher {
  public:
    TiledMatcher(const MatchRequest& request, const PairWindows& pair, const stages::FoundRange& range,
                 job::Backend& backend)
        : request_(request), pair_(pair), range_(range), backend_(backend), threads_(backend.threads()) {
        for (int y = 0; y < height(); y += request.tile_px)
            for (int x = 0; x < width(); x += request.tile_px)
                tiles_.push_back(
                    {x, y, std::min(request.tile_px, width() - x), std::min(request.tile_px, height() - y)});
    }

    // Matches all tiles, row by row; `take` receives the pixel rows of each row of tiles.
    template <typename Take>
    TiledMatch match(const job::RunLog& log, const Take& take) {
        std::vector<float> rows;
        std::future<StereoPair> next = read(0);
        for (std::size_t k = 0; k < tiles_.size(); ++k) {
            log.progress(static_cast<double>(k) / static_cast<double>(tiles_.size()));
            const mesh_tiles::MapRect& tile = tiles_[k];
            const StereoPair pair = next.get();
            if (k + 1 < tiles_.size()) next = read(k + 1);
            rows.resize(static_cast<std::size_t>(width()) * tile.height);
            put_tile(tile, pair, rows);
            if (tile.x + tile.width == width()) take(rows.data(), tile.height);
        }
        job::check_detail(is_left_blank_, is_right_blank_);
        job::check_matches(matched_ > 0);
        const double pixels = static_cast<double>(width()) * height();
        return {width(), height(), static_cast<int>(tiles_.size()), static_cast<double>(matched_) / pixels,
                static_cast<double>(known_) / pixels};
    }

  private:
    int width() const { return pair_.left.width(); }
    int height() const { return pair_.left.height(); }
    mesh_tiles::MapRect window(const mesh_tiles::MapRect& tile) const {
        return window_of_tile(tile, {width(), height()}, range_.config, request_.collar_px);
    }
    // Reads the pair of tile k, at the same time as the work on the tile before.
    std::future<StereoPair> read(std::size_t k) const {
        return start_work(threads_, [this, k] {
            const mesh_tiles::MapRect w = window(tiles_[k]);
            auto right = start_work(threads_, [&] { return pair_.right.read(w.x, w.y, w.width, w.height); });
            Image left = pair_.left.read(w.x, w.y, w.width, w.height);
            return StereoPair{std::move(left), right.get()};
        });
    }

    void put_tile(const mesh_tiles::MapRect& tile, const StereoPair& pair, std::vector<float>& rows) {
        is_left_blank_ = is_left_blank_ && checks::is_blank(pair.left);
        is_right_blank_ = is_right_blank_ && checks::is_blank(pair.right);
        const StereoPair as_matched = stages::corrected(pair, range_.correction, threads_);
        const DisparityMap map = stages::match_range(as_matched, range_.config, backend_, threads_);
        const std::vector<std::uint8_t>& alpha = pair.left.alpha;
        const bool has_alpha = request_.config.input.mask.alpha && !alpha.empty();
        const mesh_tiles::MapRect around = window(tile);
        for (int y = 0; y < tile.height; ++y) {
            const std::size_t from = static_cast<std::size_t>(tile.y - around.y + y) * map.width +
                                     static_cast<std::size_t>(tile.x - around.x);
            float* const to = &rows[static_cast<std::size_t>(y) * width() + tile.x];
            for (int x = 0; x < tile.width; ++x) {
                const std::size_t i = from + x;
                const bool is_hidden = has_alpha && alpha[i] < kOpaque;
                to[x] = is_hidden ? kUnknownDisparity : map.values[i];
                matched_ += !is_hidden && map.origins[i] == PixelOrigin::matched;
                known_ += DisparityMap::known(to[x]);
            }
        }
    }

    const MatchRequest& request_;
    const PairWindows& pair_;
    const stages::FoundRange& range_;
    job::Backend& backend_;
    int threads_;
    std::vector<mesh_tiles::MapRect> tiles_;
    long long matched_ = 0, known_ = 0;
    bool is_left_blank_ = true, is_right_blank_ = true;
};

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

mesh_tiles::MapRect window_of_tile(const mesh_tiles::MapRect& tile, const PairSize& whole,
                                   const stages::DisparityConfig& ranged, int collar_px) {
    const int least_px = ranged.min_disparity_px, count = ranged.num_disparities_px;
    const int reach_left = std::max(0, least_px + stages::round_up_range(count)),
              reach_right = std::max(0, -least_px);
    int left = aligned_below(std::max(0, tile.x - collar_px - reach_left));
    int right = aligned_above(tile.x + tile.width + collar_px + reach_right, whole.width);
    // The matcher does not accept a range wider than the pictures.
    const int least_width = std::max({16, count, std::abs(least_px) + 1});
    right = std::max(right, aligned_above(left + least_width, whole.width));
    left = std::min(left, aligned_below(std::max(0, right - least_width)));
    const int top = aligned_below(std::max(0, tile.y - collar_px));
    const int bottom = aligned_above(tile.y + tile.height + collar_px, whole.height);
    return {left, top, right - left, bottom - top};
}

TiledMatch match_in_tiles(const MatchRequest& request, job::Backend& backend, job::RunLog& log) {
    check_request(request);
    const readers::ReaderLimits& limits = request.config.limits.reading;
    const auto left = readers::PictureWindows::open(request.left, limits);
    const auto right = readers::PictureWindows::open(request.right, limits);
    const PairWindows pair{*left, *right};
    files::OutputSet outputs;
    outputs.place(request.map);
    readers::MapWriter writer(outputs.files(), request.map, left->width(), left->height());
    const stages::FoundRange range = log.stage("range", [&] {
        return find_range_of_whole(pair, camera_of(request, *left), request.config.disparity,
                                   backend.threads(), log);
    });
    TiledMatcher matcher(request, pair, range, backend);
    const TiledMatch match = log.stage("disparity", [&] {
        return matcher.match(log, [&](const float* rows, int count) { writer.write(rows, count); });
    });
    writer.finish();
    outputs.commit();
    return match;
}

}  // namespace hexrelief::tiles
