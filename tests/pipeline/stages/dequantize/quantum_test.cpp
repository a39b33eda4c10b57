#include "pipeline/stages/dequantize/noise.h"

#include <gtest/gtest.h>

#include <random>

namespace hexrelief::stages {
namespace {

DisparityMap map_of(std::vector<float> values) {
    return {static_cast<int>(values.size()), 1, std::move(values)};
}

TEST(Quantum, IsFoundForEachScale) {
    for (const double scale : {1.0, 1.5, 2.0, 3.0, 4.0, 7.0, 8.0}) {
        DisparityMap map = map_of({});
        std::mt19937 random(1);
        for (int i = 0; i < 4000; ++i)
            map.values.push_back(static_cast<float>((20 + random() % 230) / scale));
        map.width = 4000;
        EXPECT_NEAR(find_quantum_px(map), 1 / scale, 1e-5 / scale) << scale;
    }
}

TEST(Quantum, LeavesOutTheSharedOffset) {
    EXPECT_DOUBLE_EQ(find_quantum_px(map_of({7.3125f, 8.3125f, 12.3125f, 3.3125f})), 1);
}

TEST(Quantum, IsTheLargestThatServes) {
    EXPECT_DOUBLE_EQ(find_quantum_px(map_of({10, 12, 15, 18})), 1);
    EXPECT_DOUBLE_EQ(find_quantum_px(map_of({10, 10.5f, 12})), 0.5);
}

TEST(Quantum, IgnoresUnknownPixels) {
    EXPECT_DOUBLE_EQ(find_quantum_px(map_of({kUnknownDisparity, 5, kUnknownDisparity, 6})), 1);
    EXPECT_DOUBLE_EQ(find_quantum_px(map_of({kUnknownDisparity, kUnknownDisparity})), 0);
}

TEST(Quantum, IsNoneForFloatsFineStepsLargeStepsAndOneValue) {
    DisparityMap floats = map_of({}), fine = map_of({});
    std::mt19937 random(2);
    for (int i = 0; i < 1000; ++i) {
        floats.values.push_back(std::uniform_real_distribution<float>(5, 90)(random));
        fine.values.push_back(static_cast<float>(random() % 2000) / 16);
    }
    EXPECT_EQ(find_quantum_px(floats), 0);
    EXPECT_EQ(find_quantum_px(fine), 0);
    EXPECT_EQ(find_quantum_px(map_of({10, 12, 14})), 0);
    EXPECT_EQ(find_quantum_px(map_of({10, 10, 10})), 0);
}

TEST(Quantum, OneFloatAmongWholePixelsIsEnoughForNone) {
    DisparityMap map = map_of({});
    for (int i = 0; i < 1000; ++i) map.values.push_back(static_cast<float>(10 + i % 37));
    map.width = 1000;
    EXPECT_EQ(find_quantum_px(map), 1);
    map.values[777] += 0.03f;
    EXPECT_EQ(find_quantum_px(map), 0);
}

}  // namespace
}  // namespace hexrelief::stages
