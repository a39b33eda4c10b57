// Tests bench_paper's scene and its rows.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "pipeline/stages/density.h"
#include "tests/cuda/paper/balls_scene.h"
#include "tests/cuda/paper/experiments.h"

namespace hexrelief::paper {
namespace {

TEST(BenchPaper, TheSceneIsTheSameAtEverySize) {
    const DisparityMap large = made_up_scene(800, 600), small = made_up_scene(200, 150);
    int far_apart = 0;
    for (int y = 0; y < 150; ++y)
        for (int x = 8; x < 200; ++x)
            far_apart += std::abs(small.at(x, y) - large.at(4 * x + 2, 4 * y + 2)) > 2;
    EXPECT_LT(far_apart, 150 * 192 / 20) << "only along the balls' silhouettes";
    EXPECT_FALSE(DisparityMap::known(small.at(0, 75)));
    std::set<int> values;
    for (const float d : large.values)
        if (DisparityMap::known(d)) {
            ASSERT_GE(d, 6);
            ASSERT_LE(d, 64);
            values.insert(static_cast<int>(d));
        }
    EXPECT_GT(values.size(), 25u);
    stages::DensityConfig config{.background_method = stages::BackgroundMethod::fraction, .floor = 0};
    const DensityMap density = stages::compute_density(large, config);
    const auto empty = std::count(density.values.begin(), density.values.end(), 0.0f);
    EXPECT_GT(empty, 800 * 600 / 10) << "a background";
    EXPECT_LT(empty, 800 * 600 * 9 / 10) << "and a foreground";
    EXPECT_EQ(made_up_scene(1, 1).values.size(), 1u);
}

TEST(BenchPaper, OursRunsThePapersSchedule) {
    paper::Config config{.t_max = 900, .sigma_init = 24, .co = 30, .ssr = 0, .crr = 7};
    const MeshConfig same = same_schedule(config);
    EXPECT_EQ(same.co, 30);
    EXPECT_EQ(same.ssr, 0);
    EXPECT_EQ(same.crr, 7);
    EXPECT_EQ(same.t_max, 900);
    EXPECT_EQ(same.sigma_init, 24);
    EXPECT_EQ(same.delta, 1);
    EXPECT_EQ(same.levels, 1);
    EXPECT_EQ(same.border, MeshBorder::free);
    EXPECT_FALSE(same.balance.enabled);
}

TEST(BenchPaperRows, MediansAndLimits) {
    const Times odd{{3, 1, 2}}, even{{4, 1, 2, 3}}, none;
    EXPECT_EQ(odd.median(), 2);
    EXPECT_EQ(even.median(), 2.5);
    EXPECT_EQ(even.least(), 1);
    EXPECT_EQ(even.most(), 4);
    EXPECT_TRUE(std::isnan(none.median()) && std::isnan(none.least()) && std::isnan(none.most()));
}

Row paper_row() {
    return {.experiment = "blocks",
            .map = "conesM",
            .solver = "paper",
            .baseline = Config{.kernels = Kernels::multiple,
                               .block_extraction = 64,
                               .block_search = 8,
                               .block_learning = 256},
            .kernels = {{"extraction", {{0.01}}}, {"search", {{0.02}}}, {"learning", {{0.04}}}},
            .width = 1000,
            .height = 500,
            .co = 20,
            .crr = 20,
            .som_s = {.runs = {0.25, 0.5, 0.3}},
            .stage_s = {.runs = {0.4, 0.6, 0.5}}};
}

TEST(BenchPaperRows, JsonHoldsWhatApplies) {
    const nlohmann::ordered_json json = row_json(paper_row());
    EXPECT_EQ(json["som_ms"]["median"], 300);
    EXPECT_EQ(json["som_ms"]["least"], 250);
    EXPECT_EQ(json["stage_ms"]["most"], 600);
    EXPECT_EQ(json["kernels_ms"]["learning"], 40);
    EXPECT_EQ(json["block"]["search"], 8);
    EXPECT_EQ(json["memory"], "2-texture");
    EXPECT_EQ(json["runs"], 3);
    EXPECT_FALSE(json.contains("percent_cost")) << "not measured";
    Row ours = paper_row();
    ours.solver = "hexrelief";
    ours.baseline.reset();
    ours.kernels.clear();
    ours.percent_cost = 12.5;
    const nlohmann::ordered_json other = row_json(ours);
    for (const char* key : {"kernels", "memory", "block", "escaped", "kernels_ms"})
        EXPECT_FALSE(other.contains(key)) << key;
    EXPECT_EQ(other["percent_cost"], 12.5);
}

}  // namespace
}  // namespace hexrelief::paper
