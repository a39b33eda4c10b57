#include "pipeline/tiles/matching/match_in_tiles.h"

#include <algorithm>
#include <future>
#include <utility>
#include <vector>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/steps.h"
#include "pipeline/readers/cameras/stereo_calibration_reader.h"
#include "pipeline/readers/windows/map_writer.h"
#include "pipeline/tiles/matching/whole_range.h"

namespace hexrelief::tiles {
namespace {

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

// Returns the calibration for the pair's pictures.
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
