#include "pipeline/job/backend.h"

#include <gtest/gtest.h>

namespace hexrelief::job {
namespace {

config::BackendChoice chosen(const RunSize& size, const config::Config& config = {}) {
    const BackendDecision decision = choose_backend(size, config);
    EXPECT_FALSE(decision.reason.empty());
    return decision.choice;
}

TEST(BackendChoice, SmallJobsStayOnTheCpu) {
    EXPECT_EQ(chosen({450, 375, false, 16}), config::BackendChoice::cpu);
    EXPECT_EQ(chosen({450, 375, true, 16}), config::BackendChoice::cpu);
    EXPECT_EQ(chosen({1800, 1500, false, 16}), config::BackendChoice::cpu);
}

TEST(BackendChoice, LargePairsGoToADeviceWhereThereIsOne) {
    EXPECT_EQ(chosen({1282, 1110, true, 16}), config::BackendChoice::automatic);
    EXPECT_EQ(chosen({1800, 1500, true, 2}), config::BackendChoice::automatic);
}

TEST(BackendChoice, ManySmallJobsShareTheStart) {
    EXPECT_EQ(chosen({450, 375, true, 16, 100}), config::BackendChoice::automatic);
}

TEST(BackendChoice, MoreThreadsADisparityAndAVertexCount) {
    const auto seconds = [](const RunSize& size, const config::Config& config) {
        return estimated_cpu_seconds(size, config);
    };
    config::Config config;
    const RunSize size{900, 750, true, 4};
    config.disparity.num_disparities_px = 64;
    const double few = seconds(size, config);
    config.disparity.num_disparities_px = 128;
    const double more = seconds(size, config);
    EXPECT_LT(few, more);
    config.mesh.spacing_px /= 2;
    EXPECT_LT(more, seconds(size, config));
    EXPECT_LT(seconds(size, config), [&] {
        config::Config budgeted = config;
        budgeted.budget.vertices = 1000;
        return seconds(size, budgeted);
    }());
    config.disparity.method = stages::DisparityMethod::sgbm;  // which the CPU does on either backend
    EXPECT_EQ(seconds(size, config), seconds({900, 750, false, 4}, config));
    EXPECT_GT(seconds({900, 750, true, 1}, config), seconds({900, 750, true, 16}, config));
}

TEST(BackendChoice, WhatIsConfiguredStays) {
    config::Config config;
    config.run.backend = config::BackendChoice::cuda;
    EXPECT_EQ(chosen({450, 375, false, 16}, config), config::BackendChoice::cuda);
    config.run.backend = config::BackendChoice::cpu;
    EXPECT_EQ(chosen({8192, 8192, true, 1}, config), config::BackendChoice::cpu);
    config.run.backend = config::BackendChoice::automatic;
    config.mesh.method = MeshMethod::sequential;
    EXPECT_EQ(chosen({8192, 8192, true, 1}, config), config::BackendChoice::cpu);
}

}  // namespace
}  // namespace hexrelief::job
