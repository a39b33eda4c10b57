// Tests the maps of pairs matched in tiles, against the truth and against pairs matched as a whole.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "pipeline/files/sha256.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/tiles/matching/match_in_tiles.h"
#include "tests/mesher/busy_map.h"
#include "tests/pipeline/process.h"

namespace hexrelief::tiles {
namespace {

using namespace test;
using namespace testing_mesher;

using testing_mesher::uniform;

// Returns value noise of several sizes, 0 to 1.
float texture(float x, int y, std::uint32_t seed) {
    float sum = 0, weight = 0.5f;
    for (int cell = 16; cell >= 2; cell /= 2, weight *= 0.7f) {
        const float u = x / static_cast<float>(cell) + 100;
        const auto column = static_cast<std::uint32_t>(u), row = static_cast<std::uint32_t>(y / cell);
        const float right = u - static_cast<float>(column);
        const float left_value = uniform(column, row, seed + cell),
                    value = uniform(column + 1, row, seed + cell);
        sum += weight * (left_value + (value - left_value) * right);
    }
    return sum;
}

struct MadePair {
    DisparityMap truth;
    StereoPair pair;
};

// Returns a hilly ground with discs and bars in front of it, all with noise and a fine texture that is weak
// in places. The parts that only the right camera sees have their own texture.
MadePair make_pair(int width, int height) {
    MadePair made{{width, height, std::vector<float>(static_cast<std::size_t>(width) * height)},
                  {{width, height, 1, {}}, {width, height, 1, {}}}};
    made.pair.left.pixels.resize(made.truth.values.size());
    made.pair.right.pixels.resize(made.truth.values.size());
    const auto grey = [](float value, float strength, std::uint32_t i) {
        const float noise = 6 * (uniform(i, 1, 5) + uniform(i, 2, 5) - 1);
        return static_cast<std::uint8_t>(
            std::clamp(120 + 90 * strength * (value - 0.8f) + noise, 0.0f, 255.0f));
    };
    std::vector<float> nearest(static_cast<std::size_t>(width));
    for (int y = 0; y < height; ++y) {
        float* const d = &made.truth.at(0, y);
        const auto at = [&](int x) { return static_cast<std::uint32_t>(y * width + x); };
        const auto strength = [&](float x) {
            return 0.06f + std::max(0.0f, std::sin(x / 41) * std::sin(static_cast<float>(y) / 53 + x / 90));
        };
        for (int x = 0; x < width; ++x) {
            d[x] = 10 + 4 * std::sin(static_cast<float>(x) / 83) + 3 * std::sin(static_cast<float>(y) / 61);
            for (std::uint32_t k = 0; k < 60; ++k) {
                const float r = 10 + 30 * uniform(k, 3, 9), near = 18 + 20 * uniform(k, 4, 9);
                const float dx = static_cast<float>(x) - uniform(k, 1, 9) * static_cast<float>(width);
                const float dy = static_cast<float>(y) - uniform(k, 2, 9) * static_cast<float>(height);
                const bool inside =
                    k % 3 ? dx * dx + dy * dy < r * r : std::fabs(dx) < 4 && std::fabs(dy) < 2 * r;
                if (inside) d[x] = std::max(d[x], near + 0.05f * dy);
            }
            made.pair.left.at(x, y)[0] =
                grey(texture(static_cast<float>(x), y, 1), strength(static_cast<float>(x)), at(x));
        }
        std::fill(nearest.begin(), nearest.end(), 0.0f);
        for (int x = 0; x < width; ++x)
            made.pair.right.at(x, y)[0] = grey(texture(static_cast<float>(x), y, 2), 1, at(x) + 77);
        for (int x = 0; x + 1 < width; ++x) {
            const float from = static_cast<float>(x) - d[x], to = static_cast<float>(x + 1) - d[x + 1];
            if (std::fabs(d[x + 1] - d[x]) > 0.5f) continue;
            for (int at_right = std::max(0, static_cast<int>(std::ceil(from)));
                 static_cast<float>(at_right) <= to; ++at_right) {
                if (nearest[static_cast<std::size_t>(at_right)] >= d[x]) continue;
                nearest[static_cast<std::size_t>(at_right)] = d[x];
                const float source =
                    static_cast<float>(x) + (static_cast<float>(at_right) - from) / (to - from);
                made.pair.right.at(at_right, y)[0] =
                    grey(texture(source, y, 1), strength(source), at(at_right) + 99);
            }
        }
    }
    return made;
}

void write_pnm(const std::string& path, const Image& image) {
    std::ofstream file(path, std::ios::binary);
    file << (image.channels == 3 ? "P6\n" : "P5\n") << image.width << " " << image.height << "\n255\n";
    file.write(reinterpret_cast<const char*>(image.pixels.data()),
               static_cast<std::streamsize>(image.pixels.size()));
}

DisparityMap match(const MatchRequest& request, int threads = 2) {
    job::RunLog log;
    match_in_tiles(request, *job::pick_backend(config::BackendChoice::cpu, threads), log);
    return readers::read_disparity_map(request.map, {});
}

class PairFolder {
  public:
    PairFolder(int width, int height) : made(make_pair(width, height)) {
        write_pnm(folder_ / "left.pgm", made.pair.left);
        write_pnm(folder_ / "right.pgm", made.pair.right);
    }
    MatchRequest request() const {
        MatchRequest request{
            .left = folder_ / "left.pgm", .right = folder_ / "right.pgm", .map = folder_ / "map.tif"};
        request.config.disparity.num_disparities_px = 48;
        return request;
    }
    std::string operator/(const std::string& name) const { return folder_ / name; }
    std::size_t entries() const { return folder_.entries(); }

    MadePair made;

  private:
    TemporaryFolder folder_;
};

struct Errors {
    double bad2_percent = 0, rmse_px = 0;
};

// Returns the errors of the pixels within 16 px of a tile's border, or of the others.
Errors errors(const DisparityMap& map, const DisparityMap& truth, int tile, bool near_border) {
    const auto is_near = [&](int at, int size) {
        const int border = (at + tile / 2) / tile * tile;
        return border > 0 && border < size && std::abs(at - border) <= 16;
    };
    double pixels = 0, bad = 0, squares = 0;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if ((is_near(x, map.width) || is_near(y, map.height)) != near_border) continue;
            const double error = map.at(x, y) - truth.at(x, y);
            ++pixels;
            bad += !(std::fabs(error) <= 2);
            squares += error * error;
        }
    return {100 * bad / pixels, std::sqrt(squares / pixels)};
}

// Returns by how much errors are larger near borders than elsewhere.
Errors excess(const DisparityMap& map, const DisparityMap& truth, int tile) {
    const Errors near = errors(map, truth, tile, true), inside = errors(map, truth, tile, false);
    return {near.bad2_percent - inside.bad2_percent, near.rmse_px - inside.rmse_px};
}

double differing_percent(const DisparityMap& a, const DisparityMap& b) {
    double differing = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) differing += a.values[i] != b.values[i];
    return 100 * differing / static_cast<double>(a.values.size());
}

// Errors near a border are no larger than elsewhere, except as far as they are so in the map matched as a
// whole. The same limits detect collars that are too small.
TEST(MatchTiles, BordersAreAsGoodAsTheInside) {
    constexpr int kTile_px = 192;
    constexpr double kBad2_percent = 0.05, kRmse_px = 0.02, kDiffering_percent = 8;
    const PairFolder folder(576, 576);
    const DisparityMap& truth = folder.made.truth;
    MatchRequest request = folder.request();
    const DisparityMap whole = match(request);
    const Errors expected = excess(whole, truth, kTile_px);
    request.tile_px = kTile_px;
    for (const int collar_px : {0, 8, kCollar_px}) {
        request.collar_px = collar_px;
        const DisparityMap map = match(request);
        const Errors found = excess(map, truth, kTile_px);
        const double bad2 = std::fabs(found.bad2_percent - expected.bad2_percent);
        const double rmse = std::fabs(found.rmse_px - expected.rmse_px);
        SCOPED_TRACE(std::to_string(collar_px) + " px: bad2 " + std::to_string(bad2) + " %, RMSE " +
                     std::to_string(rmse) + " px, differing " +
                     std::to_string(differing_percent(map, whole)));
        const bool is_enough = collar_px == kCollar_px;
        EXPECT_EQ(bad2 < kBad2_percent, is_enough);
        EXPECT_EQ(rmse < kRmse_px, is_enough);
        EXPECT_EQ(differing_percent(map, whole) < kDiffering_percent, is_enough);
    }
}

TEST(MatchTiles, OneTileIsTheMapOfThePair) {
    const PairFolder folder(300, 120);
    const MatchRequest request = folder.request();
    const DisparityMap map = match(request);
    const DisparityMap expected = stages::compute_disparity(folder.made.pair, request.config.disparity, 2);
    EXPECT_EQ(map.values, expected.values);
}

TEST(MatchTiles, AreTheSameBytesForAnyNumberOfThreads) {
    const PairFolder folder(330, 190);
    MatchRequest request = folder.request();
    request.tile_px = 64;
    request.collar_px = 24;
    request.config.disparity.num_disparities_px = 0;
    std::string sum;
    for (const int threads : {1, 4}) {
        match(request, threads);
        if (sum.empty()) sum = files::sha256_of_file(request.map);
        EXPECT_EQ(files::sha256_of_file(request.map), sum);
    }
    request.map = folder / "map.pfm";
    EXPECT_EQ(match(request).values, readers::read_disparity_map(folder / "map.tif", {}).values);
}

TEST(MatchTiles, WindowsHoldTileCollarAndReach) {
    stages::DisparityConfig config;
    config.num_disparities_px = 100;  // 112 are searched
    const PairSize whole{5000, 3000};
    mesh_tiles::MapRect w = window_of_tile({2048, 1024, 512, 512}, whole, config, 51);
    EXPECT_EQ(w.x, (2048 - 51 - 112) / 32 * 32);
    EXPECT_EQ(w.x + w.width, 2624);   // 2611 unaligned
    EXPECT_EQ(w.y, 960);              // 973 unaligned
    EXPECT_EQ(w.y + w.height, 1600);  // 1587 unaligned
    config.min_disparity_px = -150;
    w = window_of_tile({2048, 1024, 512, 512}, whole, config, 50);
    EXPECT_EQ(w.x, 1984);            // 1998 unaligned
    EXPECT_EQ(w.x + w.width, 2784);  // 2760 unaligned
    // The window is as wide as the range, at either side of the picture.
    config.min_disparity_px = 0;
    config.num_disparities_px = 480;
    w = window_of_tile({0, 0, 64, 64}, whole, config, 10);
    EXPECT_EQ(w.x, 0);
    EXPECT_EQ(w.width, 480);
    w = window_of_tile({4999, 2999, 1, 1}, {5000, 3000}, config, 0);
    EXPECT_GE(w.width, 480);
    EXPECT_EQ(w.x + w.width, 5000);
    EXPECT_EQ(w.y + w.height, 3000);
}

TEST(MatchTiles, TransparentPixelsAreUnknown) {
    const TemporaryFolder folder;
    MatchRequest request{.left = sample("inputs/cut_out.png"),
                         .right = sample("inputs/right.png"),
                         .map = folder / "map.tif",
                         .tile_px = 64};
    const Image left = readers::read_image(request.left);
    ASSERT_EQ(left.alpha.size(), left.pixels.size() / left.channels);
    std::vector<bool> seen;
    for (const std::uint8_t alpha : left.alpha) seen.push_back(alpha >= kOpaque);
    const auto known = [&] {
        std::vector<bool> all;
        for (const float d : match(request).values) all.push_back(DisparityMap::known(d));
        return all;
    };
    EXPECT_EQ(known(), seen);
    request.config.input.mask.alpha = false;
    EXPECT_EQ(known(), std::vector<bool>(seen.size(), true));
}

// The range is that of the calibration, else that of the pair as a whole; for a larger pair, nearly so.
TEST(MatchTiles, SearchTheRangeOfTheWholePair) {
    const PairFolder folder(400, 300);
    const auto left = readers::PictureWindows::open(folder / "left.pgm"),
               right = readers::PictureWindows::open(folder / "right.pgm");
    std::vector<std::string> told;
    job::RunLog log;
    log.decides = [&](const std::string& decision) { told.push_back(decision); };
    const auto range = [&](const Calibration& calibration, const stages::DisparityConfig& config) {
        return find_range_of_whole({*left, *right}, calibration, config, 2, log).config.num_disparities_px;
    };
    EXPECT_EQ(range({}, {}), stages::find_range(folder.made.pair, {}, {}, 2).config.num_disparities_px);
    Calibration calibration{.ndisp_px = 77};
    EXPECT_EQ(range(calibration, {}), 77);
    stages::DisparityConfig given{.num_disparities_px = 96};
    EXPECT_EQ(range(calibration, given), 96);
    ASSERT_EQ(told.size(), 3u);
    EXPECT_CONTAINS(told[0], "chosen from the pair");
    EXPECT_CONTAINS(told[1], "80 px searched from 0 px on, by the calibration's ndisp");
    EXPECT_CONTAINS(told[2], "96 px searched");
}

// The pair has 24 Mpx: each pixel of the small pair becomes 7 x 7 px.
TEST(MatchTiles, LargePairsAreShrunkForTheirRange) {
    const PairFolder folder(800, 600);
    const auto enlarged = [](const Image& image) {
        Image large{7 * image.width, 7 * image.height, 1, {}};
        for (int y = 0; y < large.height; ++y)
            for (int x = 0; x < large.width; ++x) large.pixels.push_back(*image.at(x / 7, y / 7));
        return large;
    };
    write_pnm(folder / "left.pgm", enlarged(folder.made.pair.left));
    write_pnm(folder / "right.pgm", enlarged(folder.made.pair.right));
    const auto left = readers::PictureWindows::open(folder / "left.pgm"),
               right = readers::PictureWindows::open(folder / "right.pgm");
    std::string told;
    job::RunLog log;
    log.decides = [&](const std::string& decision) { told = decision; };
    const int count = find_range_of_whole({*left, *right}, {}, {}, 2, log).config.num_disparities_px;
    const int small = stages::find_range(folder.made.pair, {}, {}, 2).config.num_disparities_px;
    EXPECT_GT(count, 7 * (small - 16));
    EXPECT_LT(count, 7 * (small + 16));
    EXPECT_CONTAINS(told, "chosen from the pair at 1/2 of its size");
}

struct BadRun {
    std::vector<std::string> arguments;
    int exit_code;
    std::string told;
};

TEST(MatchTiles, BadInputsAreRefusedInALine) {
    const PairFolder folder(128, 64);
    const std::string left = folder / "left.pgm", right = folder / "right.pgm", map = folder / "map.tif";
    write_pnm(folder / "small.pgm", {127, 64, 1, std::vector<std::uint8_t>(127 * 64, 9)});
    write_pnm(folder / "blank.pgm", {128, 64, 1, std::vector<std::uint8_t>(128 * 64, 9)});
    write_pnm(folder / "narrow.pgm", {12, 64, 1, std::vector<std::uint8_t>(12 * 64, 9)});
    write_text(folder / "damaged.pgm", "P5\n128 64\n255\nshort");
    const std::size_t entries = folder.entries();
    const std::vector<BadRun> runs = {
        {{folder / "none.pgm", right, "-o", map}, 3, "no such file"},
        {{left, folder / "small.pgm", "-o", map}, 3, "127x64; a rectified pair has one size"},
        {{left, folder / "damaged.pgm", "-o", map}, 3, "truncated"},
        {{left, folder / "blank.pgm", "-o", map}, 3, "the right picture is blank"},
        {{folder / "narrow.pgm", folder / "narrow.pgm", "-o", map}, 3, "at least 16 columns"},
        {{left, right, "-o", folder / "map.png"}, 2, ".tif, .tiff or .pfm"},
        {{left, right, "-o", left}, 2, "would overwrite the input"},
        {{left, right, "-o", left + "/map.tif"}, 4, ""},
        {{left, right, "-o", map, "--tile", "8"}, 2, "--tile"},
        {{left, right, "-o", map, "--set", "disparity.method=sgbm"}, 2, "disparity.method: must be sgm"},
        {{left, right, "-o", map, "--set", "disparity.num_disparities_px=144"},
         2,
         "wider than the image (128)"},
        {{left, right, "-o", map, "--set", "input.calibration.rectify=always"}, 2, "rectify"},
        {{left, right, "-o", map, "--calib", sample("inputs/stereo.yml")}, 3, "rectified already"}};
    for (const BadRun& run : runs) {
        const ProcessResult result = run_program({"tiles", "match", "--backend", "cpu"}, run.arguments);
        EXPECT_EQ(result.exit_code, run.exit_code) << result.err;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        EXPECT_CONTAINS(result.err, run.told);
        EXPECT_EQ(folder.entries(), entries) << run.told;
    }
}

TEST(MatchTiles, InterruptedRunsLeaveNothing) {
    const PairFolder folder(600, 400);
    const std::size_t entries = folder.entries();
    const pid_t run = start_program({"tiles", "match", folder / "left.pgm", folder / "right.pgm", "-o",
                                     folder / "map.tif", "--tile", "64", "--backend", "cpu"});
    for (int k = 0; k < 10000 && folder.entries() == entries; ++k) usleep(1000);  // until the map has begun
    EXPECT_GT(folder.entries(), entries);
    kill(run, SIGTERM);
    EXPECT_EQ(wait_for_exit(run), 130);
    EXPECT_EQ(folder.entries(), entries);
}

TEST(MatchTiles, MapsArePlannedAndSolved) {
    const PairFolder folder(300, 220);
    const std::string map = folder / "map.tif";
    const ProcessResult matched =
        expect_success({"tiles", "match", folder / "left.pgm", folder / "right.pgm", "-o", map, "--tile",
                        "128", "--verbose", "--backend", "cpu"});
    EXPECT_CONTAINS(matched.out, "300x220 px in 6 tiles");
    EXPECT_CONTAINS(matched.err, "chosen from the pair");
    expect_success(
        {"tiles", "plan", map, "-o", folder / "plan", "--color", folder / "left.pgm", "--backend", "cpu"});
    expect_success({"tiles", "solve", folder / "plan", "--backend", "cpu"});
}

}  // namespace
}  // namespace hexrelief::tiles
