// Tests the whole matcher against the oracle, which shares no code with it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "compare.h"
#include "matching_scenes.h"

namespace hexrelief::matching::oracle {
namespace {

TEST(MatcherOracle, FindsTheSame) {
    int filled = 0, matched = 0, helped = 0;
    for (int number = 0; number < scene_count(); ++number) {
        const Scene scene = make_scene(number);
        const MatchedMap map = match_pair(scene.pair, config_of(scene.settings), 1 + number % 3);
        const Views winners = match_views(scene.pair, scene.settings);
        const HalfSize half_size = match_at_half_size(scene.pair, scene.settings);
        const Result expected = refine(scene.pair, winners, &half_size, scene.settings);
        EXPECT_EQ("", difference(expected.disparities, grid_of(map))) << scene.name;
        helped += difference(expected.disparities,
                             refine(scene.pair, winners, nullptr, scene.settings).disparities) != "";
        EXPECT_EQ("", difference(expected.is_matched, matched_of(map))) << scene.name;
        const MatchedMap trusted = match_trusted(scene.pair, config_of(scene.settings), 2);
        EXPECT_EQ("", difference(trusted_matches(winners, scene.settings).left, grid_of(trusted)))
            << scene.name;
        EXPECT_EQ("", difference(expected.is_matched, matched_of(trusted))) << scene.name;
        for (const std::uint8_t one : map.is_matched) (one ? matched : filled) += 1;
    }
    EXPECT_GT(matched, 5000);  // else the scenes test little
    EXPECT_GT(filled, 5000);
    EXPECT_GT(helped, 0);  // by matches at half size
}

TEST(MatcherOracle, IncludesNothingOfTheMatcher) {
    std::set<std::string> seen;
    for (const std::string name :
         {"matching_oracle.h", "oracle_sgm.cpp", "oracle_windows.cpp", "oracle_refine.cpp",
          "oracle_segments.cpp", "oracle_votes.cpp", "matching_scenes.h", "matching_scenes.cpp"}) {
        std::ifstream in(std::filesystem::path(HEXRELIEF_SOURCE_DIR "/tests/pipeline/matching") / name);
        for (std::string line; std::getline(in, line);)
            if (line.starts_with("#include \"")) {
                seen.insert(line);
                EXPECT_TRUE(line == "#include \"matching_oracle.h\"" ||
                            line == "#include \"matching_scenes.h\"" ||
                            line == "#include \"pipeline/data/disparity_map.h\"")
                    << name << ": " << line;
            }
    }
    EXPECT_EQ(seen.size(), 3u);
}

}  // namespace
}  // namespace hexrelief::matching::oracle
