// Tests the cellular method, bit for bit, against plain loops.
#include <gtest/gtest.h>

#include "tests/mesher/densities.h"
#include "tests/mesher/naive_som.h"

namespace hexrelief::som {
namespace {

using namespace testing_mesher;

struct OracleCase {
    std::string name;
    DensityMap density;
    MeshConfig config;
    int levels;  // number of levels that the run must have

    friend void PrintTo(const OracleCase& c, std::ostream* out) { *out << describe(c.density, c.config); }
};

// The cases have folds at a magnification of 1.3, which stands for its default.
MeshConfig quick(int levels, int t_max, MeshConfig config = {}) {
    config.levels = levels;
    config.t_max = t_max;
    config.balance.enabled = false;  // the oracle only trains
    if (config.magnification == MeshConfig{}.magnification) config.magnification = 1.3;
    return config;
}

OracleCase made(std::string name, DensityMap density, int levels, int t_max, const MeshConfig& config = {}) {
    return {std::move(name), std::move(density), quick(levels, t_max, config), levels};
}

std::vector<OracleCase> cases() {
    const DensityMap bumps = bumps_density(60, 48), wide = bumps_density(160, 150);
    return {
        made("OneLevel", bumps, 1, 40),
        made("TwoLevels", wide, 2, 20),
        made("FoldsOfThreeLevelsAreRepaired", bumps_density(101, 99), 3, 4, {.spacing_px = 2, .prr = 1}),
        made("OddSize", bumps_density(61, 53), 1, 40),
        made("LastCellsSmaller", noise_density(57, 49, 3), 1, 40, {.co = 13}),
        made("FreeBorder", bumps, 1, 40, {.border = MeshBorder::free}),
        made("PaperRule", bumps, 1, 60,
             {.sigma_init = 4, .co = 20, .delta = 1, .magnification = 1, .border = MeshBorder::free}),
        made("ExactSearch", bumps, 1, 40, {.ssr = 0, .crr = 1}),
        made("AlwaysTheNewestPositions", bumps, 1, 40, {.prr = 1}),
        made("BatchesThatARefreshCuts", bumps, 1, 40, {.crr = 16, .prr = 7}),
        made("BatchesThatGrow", bumps_density(101, 99), 2, 40,
             {.spacing_px = 3, .crr = 9, .prr = 2, .prr_final = 40}),
        made("BatchesThatShrink", bumps, 1, 40, {.prr = 12, .prr_final = 1}),
        made("UnlimitedSearchOnStaleLists", noise_density(60, 48, 7), 1, 40, {.co = 7, .ssr = 0, .crr = 50}),
        made("NarrowSearchLosesPoints", noise_density(60, 48, 8), 1, 30,
             {.spacing_px = 9, .co = 2, .ssr = 1, .crr = 1000}),
        made("FoldsOfAFreeBorderAreRepaired", bumps_density(101, 99), 3, 12,
             {.spacing_px = 2, .prr = 1, .border = MeshBorder::free}),
        made("ManyDrawsACell", bumps, 1, 30, {.delta = 23.5}),
        made("DrawsByTheThousand", bumps, 1, 3, {.delta = 1000}),
        made("DrawsByTheThousandEverywhere", flat_density(60, 48), 1, 2, {.delta = 1000}),
        made("FractionalDelta", bumps, 1, 80, {.delta = 0.37}),
        made("PixelCells", noise_density(30, 24, 1), 1, 20, {.co = 1, .delta = 0.5, .ssr = 4}),
        made("OneCell", bumps, 1, 60, {.co = 64}),
        made("WideSeed", bumps, 1, 40, {.seed = 0xFEDCBA9876543210u}),
        made("HalfLearningRate", bumps, 1, 40, {.alpha_init = 0.5}),
    };
}

class SomOracle : public testing::TestWithParam<OracleCase> {};

TEST_P(SomOracle, SamePositionsToTheBit) {
    const OracleCase& c = GetParam();
    const NaiveResult naive = naive_som(c.density, c.config);
    ASSERT_EQ(naive.levels, c.levels);
    ASSERT_GT(naive.draws, 20);
    const HexMesh2D mesh = solve(c.density, c.config);
    ASSERT_EQ(mesh.columns, naive.mesh.columns);
    ASSERT_EQ(mesh.rows, naive.mesh.rows);
    int different = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        if (!(mesh.positions[i] == naive.mesh.positions[i]) && ++different <= 3)
            ADD_FAILURE() << "vertex " << i << ": (" << mesh.positions[i].x << ", " << mesh.positions[i].y
                          << "), the oracle's (" << naive.mesh.positions[i].x << ", "
                          << naive.mesh.positions[i].y << ")";
    EXPECT_EQ(different, 0) << describe(c.density, c.config);
    if (c.name == "NarrowSearchLosesPoints") {
        EXPECT_GT(naive.lost_draws, 0) << "the case does not test what it says";
    }
    if (c.name.starts_with("Folds")) {
        EXPECT_GT(naive.repair_sweeps, 0) << "the case does not test what it says";
    }
}

INSTANTIATE_TEST_SUITE_P(Cases, SomOracle, testing::ValuesIn(cases()),
                         [](const auto& test) { return test.param.name; });

TEST(SomSeed, BothHalvesCount) {
    MeshConfig config = quick(1, 10);
    const DensityMap density = bumps_density(60, 48);
    const HexMesh2D one = solve(density, config);
    config.seed = 2;
    EXPECT_NE(one.positions, solve(density, config).positions);
    config.seed = 1 + (std::uint64_t{1} << 40);
    EXPECT_NE(one.positions, solve(density, config).positions) << "the seed's upper half must count";
}

}  // namespace
}  // namespace hexrelief::som
