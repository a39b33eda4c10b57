// Tests the paper's maps, if the environment variable HEXRELIEF_DATA names the folder with them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "mesher/mesher.h"
#include "mesher/quality/quality.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/stages/density.h"
#include "tests/mesher/densities.h"

namespace hexrelief::mesher {
namespace {

struct PaperMap {
    const char* name;
    const char* file;
    double scale;
    double paper_cost;  // %cost of the paper's GPU
};

const std::vector<PaperMap> kSmallMaps = {{"tsukuba", "middlebury2001/tsukuba/disp.pgm", 16, 25.89},
                                          {"rocks1", "middlebury2006/rocks1-third/disp.png", 3, 17.94},
                                          {"aloe", "middlebury2006/aloe-third/disp.png", 3, 27.15},
                                          {"venus", "middlebury2001/venus/disp.pgm", 8, 21.55},
                                          {"teddy", "middlebury2003/teddy-quarter/disp.png", 4, 18.45},
                                          {"cones", "middlebury2003/cones-quarter/disp.png", 4, 17.24}};
const std::vector<PaperMap> kMediumMaps = {{"rocks1M", "middlebury2006/rocks1-half/disp.png", 2, 21.65},
                                           {"aloeM", "middlebury2006/aloe-half/disp.png", 2, 26.39},
                                           {"conesM", "middlebury2003/cones-half/disp.pgm", 2, 18.75},
                                           {"teddyM", "middlebury2003/teddy-half/disp.pgm", 2, 21.07}};
const std::vector<PaperMap> kLargeMaps = {{"aloeL", "middlebury2006/aloe-full/disp.png", 1, 25.64},
                                          {"conesL", "middlebury2003/cones-full/disp.pgm", 1, 17.27},
                                          {"teddyL", "middlebury2003/teddy-full/disp.pgm", 1, 25.98}};
constexpr double kPaperMeanCost = 21.4;  // of the paper's GPU over the six small maps

stages::DensityConfig paper_density() {
    return {.scale_percentile = 100, .background_method = stages::BackgroundMethod::fraction, .floor = 0};
}

class Middlebury : public testing::Test {
  protected:
    void SetUp() override {
        const char* const folder = std::getenv("HEXRELIEF_DATA");
        if (folder == nullptr) GTEST_SKIP() << "HEXRELIEF_DATA is not set: the paper's maps are not measured";
        folder_ = folder;
    }

    // Returns the mean %cost; no map may be more than `slack` above the paper's, and none
    // may have inverted triangles.
    double mean_cost(const std::vector<PaperMap>& maps, const MeshConfig& config, double slack,
                     double most_cost = 100, double least_angle_deg = 0,
                     const stages::DensityConfig& density_config = paper_density()) const {
        const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
        double sum = 0;
        for (const PaperMap& paper : maps) {
            readers::DisparityFileConfig file{.scale = paper.scale};
            const DisparityMap map = readers::read_disparity_map(folder_ / paper.file, file);
            const DensityMap density = stages::compute_density(map, density_config);
            const quality::MeshQuality quality =
                quality::measure_quality(solve_mesh(density, config, threads, {}), density, threads);
            std::printf("%-8s %%cost %6.2f (the paper's %5.2f), 1st percentile angle %5.2f deg\n", paper.name,
                        quality.percent_cost, paper.paper_cost, quality.percentile1_angle_deg);
            EXPECT_EQ(quality.inverted_triangles, 0) << paper.name;
            EXPECT_LT(quality.percent_cost, std::min(most_cost, paper.paper_cost + slack)) << paper.name;
            EXPECT_GE(quality.percentile1_angle_deg, least_angle_deg) << paper.name;
            sum += quality.percent_cost / static_cast<double>(maps.size());
        }
        return sum;
    }

  private:
    std::filesystem::path folder_;
};

TEST_F(Middlebury, PaperScheduleReachesThePapersQuality) {
    EXPECT_LE(mean_cost(kSmallMaps, testing_mesher::paper_config(1500), 3), kPaperMeanCost);
}

MeshConfig unbalanced() {
    return {.t_max = 60, .prr = 2, .magnification = 1.3, .balance = {.enabled = false}};
}

TEST_F(Middlebury, UnbalancedOnSmallMaps) {
    EXPECT_LE(mean_cost(kSmallMaps, unbalanced(), 0), 16);
}
TEST_F(Middlebury, UnbalancedOnMediumMaps) {
    EXPECT_LE(mean_cost(kMediumMaps, unbalanced(), 3), kPaperMeanCost);
}
TEST_F(Middlebury, UnbalancedOnLargeMaps) {
    EXPECT_LE(mean_cost(kLargeMaps, unbalanced(), 3), kPaperMeanCost);
}

// Balanced, on the paper's density and on the program's own: no map above 5 %, and on none more than 1 % of
// the triangles thinner than 8 degrees.
TEST_F(Middlebury, DefaultOnSmallMaps) {
    EXPECT_LE(mean_cost(kSmallMaps, {}, 0, 5, 8), 2);
    EXPECT_LE(mean_cost(kSmallMaps, {}, 0, 5, 8, {}), 2);
}
TEST_F(Middlebury, DefaultOnMediumMaps) {
    EXPECT_LE(mean_cost(kMediumMaps, {}, 0, 5, 8), 2);
    EXPECT_LE(mean_cost(kMediumMaps, {}, 0, 5, 8, {}), 2);
}
TEST_F(Middlebury, DefaultOnLargeMaps) {
    EXPECT_LE(mean_cost(kLargeMaps, {}, 0, 5, 8), 2);
    EXPECT_LE(mean_cost(kLargeMaps, {}, 0, 5, 8, {}), 2);
}

}  // namespace
}  // namespace hexrelief::mesher
