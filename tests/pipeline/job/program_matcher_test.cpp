#include "pipeline/job/matchers/program_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "exporters/images/image_writer.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/stages/other_views/other_view.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

// A folder with a matcher in sh, which answers with the maps left.pfm and right.pfm in turn.
class ProgramMatcherTest : public testing::Test {
  protected:
    ProgramMatcherTest() {
        const fs::path samples = fs::path(HEXRELIEF_SOURCE_DIR) / "samples";
        pair_ = {readers::read_image(samples / "left.png"), readers::read_image(samples / "right.png")};
        left_ = readers::read_disparity_map(samples / "disparity.pfm", {});
        config_.method = stages::DisparityMethod::command;
        config_.num_disparities_px = 48;
        config_.timeout_s = 60;
        write(left_, mirrored_right());
    }

    // A map of the right view: each pixel has the nearest disparity that the left view shows of it.
    DisparityMap right() const {
        DisparityMap map = left_;
        std::fill(map.values.begin(), map.values.end(), kUnknownDisparity);
        for (int y = 0; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x) {
                const float d = left_.at(x, y);
                const int column = static_cast<int>(std::lround(x - d));
                if (column < 0) continue;
                float& seen = map.at(column, y);
                seen = DisparityMap::known(seen) ? std::max(seen, d) : d;
            }
        return map;
    }
    DisparityMap mirrored_right() const { return stages::mirrored(right()); }

    void write(const DisparityMap& left, const DisparityMap& mirrored_right) const {
        exporters::write_pfm(folder_ / "left.pfm", left.width, left.height, left.values);
        exporters::write_pfm(folder_ / "right.pfm", mirrored_right.width, mirrored_right.height,
                             mirrored_right.values);
        fs::remove(folder_ / "asked");
    }
    std::string in_folder(const std::string& name) const { return (folder_ / name).string(); }
    // Returns the words that run this text of sh, with words that it knows as $1, ...
    std::string sh(const std::string& text, const std::string& words) const {
        std::ofstream(folder_ / "matcher.sh") << "cd " << folder_.string() << "\n" << text;
        return "sh " + in_folder("matcher.sh") + " " + words;
    }
    std::string copying() const {
        return sh(
            "test -s \"$1\" && test -s \"$2\" && test \"$4\" = 48 || exit 9\n"
            "if test -e asked; then cp right.pfm \"$3\"; else touch asked; cp left.pfm \"$3\"; fi\n",
            "{left} {right} {out} {ndisp}");
    }
    void expect_maps(const stages::ViewMaps& maps) const {
        EXPECT_EQ(maps.left.values, left_.values);
        EXPECT_EQ(maps.right.values, right().values);
    }

    const test::TemporaryFolder place_;
    const fs::path folder_ = place_.path();
    StereoPair pair_;
    DisparityMap left_;
    stages::DisparityConfig config_;
    ProgramMatcher matcher_;
    RunLog log_;
};

TEST_F(ProgramMatcherTest, ACommandGivesBothViewsMaps) {
    config_.command = copying();
    expect_maps(matcher_.match(pair_, config_, 1, log_));
}

TEST_F(ProgramMatcherTest, DisparitiesOfTheOtherSignAreTurnedAndTold) {
    std::string told;
    log_.decides = [&](const std::string& decision) { told += decision; };
    DisparityMap left = left_, right = mirrored_right();
    for (DisparityMap* const map : {&left, &right})
        for (float& d : map->values)
            if (DisparityMap::known(d)) d = -d;
    write(left, right);
    config_.command = copying();
    expect_maps(matcher_.match(pair_, config_, 1, log_));
    EXPECT_CONTAINS(told, "have the other sign");
}

TEST_F(ProgramMatcherTest, AMapOfHalfTheSizeIsBroughtToThePairs) {
    const auto halved = [](const DisparityMap& map) {
        DisparityMap half{map.width / 2, map.height / 2, {}};
        for (int y = 0; y < half.height; ++y)
            for (int x = 0; x < half.width; ++x) half.values.push_back(map.at(2 * x, 2 * y) / 2);
        return half;
    };
    write(halved(left_), halved(mirrored_right()));
    config_.command = copying();
    const stages::ViewMaps maps = matcher_.match(pair_, config_, 1, log_);
    ASSERT_EQ(maps.left.values.size(), left_.values.size());
    for (int y = 0; y < left_.height; y += 2)
        for (int x = 0; x < left_.width; x += 2) ASSERT_EQ(maps.left.at(x + 1, y + 1), left_.at(x, y));
}

TEST_F(ProgramMatcherTest, DisparitiesBelowZeroAreCountedFromTheLeast) {
    // The program is shown a pair whose disparities are 10 px larger, and gives those.
    DisparityMap expected = left_;
    for (float& d : expected.values) d -= 10;
    config_.min_disparity_px = -10;
    config_.command = copying();
    EXPECT_EQ(matcher_.match(pair_, config_, 1, log_).left.values, expected.values);
}

TEST_F(ProgramMatcherTest, FailuresAreOneLine) {
    const auto expect = [&](const std::string& command, const std::string& part) {
        config_.command = command;
        EXPECT_CONTAINS(test::error_of([&] { matcher_.match(pair_, config_, 1, log_); }), part);
    };
    expect(sh("echo first >&2; echo 'no model' >&2; exit 3\n", "{out}"),
           "ended with exit code 3: 'no model'");
    expect(sh("kill -9 $$\n", "{out}"), "was ended: Killed");
    expect(in_folder("no-such-program") + " {out}", "could not be started: 'No such file");
    expect(sh("exit 0\n", "{out}"), "wrote no map");
    expect(sh("echo rubbish > \"$1\"\n", "{out}"), "disparity.pfm");
    expect(sh("head -c 1000 left.pfm > \"$1\"\n", "{out}"), "disparity.pfm");
    expect(sh("printf 'Pf\\n30 10\\n-1\\n%1200s' '' > \"$1\"\n", "{out}"), "the pictures are 320x240");
    config_.timeout_s = 1;
    expect(sh("sleep 600\n", "{out}"), "did not end within disparity.timeout_s, 1 s");
}

// A worker that writes its process number to `pids` at each request.
const char* const kWorker =
    "while read -r line; do\n"
    "  out=${line#*\\\"out\\\":\\\"}; out=${out%%\\\"*}; echo $$ >> pids\n"
    "  if test -e asked; then cp right.pfm \"$out\"; rm asked; else touch asked; cp left.pfm \"$out\"; fi\n"
    "  echo '{\"ok\": true}'\n"
    "done\n";

TEST_F(ProgramMatcherTest, AWorkerServesManyPairs) {
    config_.worker = sh(kWorker, "");
    for (int pair = 0; pair < 3; ++pair) expect_maps(matcher_.match(pair_, config_, 1, log_));
    std::ifstream pids(folder_ / "pids");
    std::string first, next;
    int requests = 0;
    for (pids >> first, requests = 1; pids >> next; ++requests) EXPECT_EQ(next, first);
    EXPECT_EQ(requests, 6);
}

TEST_F(ProgramMatcherTest, AWorkerThatFailsIsReplaced) {
    const auto expect = [&](const std::string& text, const std::string& part) {
        config_.worker = sh(text, "");
        EXPECT_CONTAINS(test::error_of([&] { matcher_.match(pair_, config_, 1, log_); }), part);
    };
    expect("read line; echo loading the model\n", "loading the model");
    expect("read line; echo 'out of memory' >&2; exit 4\n", "ended with exit code 4: 'out of memory'");
    expect("read line; exit 0\n", "ended without an answer");
    expect("read line; echo '{\"error\": \"too large\"}'\n", "not matched: 'too large'");
    expect("read line; head -c 100000 /dev/zero | tr '\\0' x; sleep 600\n", "more than 64 KiB");
    config_.timeout_s = 1;
    expect("read line; sleep 600\n", "gave no answer within disparity.timeout_s, 1 s");
    config_.timeout_s = 60;
    config_.worker = sh(kWorker, "");
    expect_maps(matcher_.match(pair_, config_, 1, log_));
}

}  // namespace
}  // namespace hexrelief::job
