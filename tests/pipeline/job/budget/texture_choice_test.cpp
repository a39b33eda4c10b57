// Tests the choice of a texture for a limit on bytes.
#include "pipeline/job/budget/budget.h"

#include <gtest/gtest.h>

namespace hexrelief::job {
namespace {

using Choices = std::vector<std::pair<int, int>>;

Choices choices(const TextureLimits& limits) {
    Choices all;
    for (const TextureChoice& choice : texture_choices(limits))
        all.emplace_back(choice.max_px, choice.quality);
    return all;
}

TEST(TextureChoice, QualityFallsFirstThenTheSize) {
    EXPECT_EQ(choices({{0, 90}, 100}), (Choices{{0, 90},
                                                {0, 80},
                                                {0, 70},
                                                {0, 60},
                                                {0, 50},
                                                {71, 70},
                                                {71, 50},
                                                {50, 70},
                                                {50, 50},
                                                {35, 70},
                                                {35, 50}}));
    EXPECT_EQ(choices({{0, 65}, 50}), (Choices{{0, 65}, {0, 60}, {0, 50}, {35, 65}, {35, 50}}));
    EXPECT_EQ(choices({{60, 30}, 60}), (Choices{{60, 30}, {42, 30}}));
}

TEST(TextureChoice, KeepsWhatIsGiven) {
    EXPECT_EQ(choices({{0, 90}, 100, true, false}), (Choices{{0, 90}, {71, 90}, {50, 90}, {35, 90}}));
    EXPECT_EQ(choices({{0, 70}, 100, false, true}), (Choices{{0, 70}, {0, 60}, {0, 50}}));
    EXPECT_EQ(choices({{0, 90}, 100, false, false}), (Choices{{0, 90}}));
}

TEST(TextureChoice, TheFirstThatFits) {
    const auto bytes = [](const TextureChoice& choice) {
        const double side = choice.max_px > 0 ? choice.max_px : 100;
        return side * side * choice.quality / 100;
    };
    const auto chosen = [&](double most, double share) {
        const TextureChoice choice = choose_texture({{0, 90}, 100}, most, share, bytes);
        return std::pair{choice.max_px, choice.quality};
    };
    EXPECT_EQ(chosen(1e6, 0.5), std::pair(0, 90));
    EXPECT_EQ(chosen(16000, 0.5), std::pair(0, 80));
    EXPECT_EQ(chosen(9999, 0.5), std::pair(71, 70));
    EXPECT_EQ(chosen(10, 0.5), std::pair(35, 50)) << "the last where none fits";
    EXPECT_EQ(chosen(1e6, 0), std::pair(35, 50));
}

}  // namespace
}  // namespace hexrelief::job
