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

MeshConfig quick(int levels, int t_max) {
    MeshConfig config;
    config.levels = levels;
    config.t_max = t_max;
    config.balance.enabled = false;  // the oracle only trains
    config.magnification = 1.3;      // the cases below have folds at this magnification
    return config;
}

template <typename Change>
OracleCase changed(std::string name, DensityMap density, int levels, int t_max, const Change& change) {
    MeshConfig config = quick(levels, t_max);
    change(config);
    return {std::move(name), std::move(density), config, levels};
}

std::vector<OracleCase> cases() {
    const DensityMap bumps = bumps_density(60, 48), wide = bumps_density(160, 150);
    const auto unchanged = [](MeshConfig&) {};
    return {
        changed("OneLevel", bumps, 1, 40, unchanged),
        changed("TwoLevels", wide, 2, 20, unchanged),
        changed("FoldsOfThreeLevelsAreRepaired", bumps_density(101, 99), 3, 4,
                [](MeshConfig& c) {
                    c.spacing_px = 2;
                    c.prr = 1;
                }),
        changed("OddSize", bumps_density(61, 53), 1, 40, unchanged),
        changed("LastCellsSmaller", noise_density(57, 49, 3), 1, 40, [](MeshConfig& c) { c.co = 13; }),
        changed("FreeBorder", bumps, 1, 40, [](MeshConfig& c) { c.border = MeshBorder::free; }),
        changed("PaperRule", bumps, 1, 60,
                [](MeshConfig& c) {
                    c.co = 20;
                    c.delta = 1;
                    c.magnification = 1;
                    c.border = MeshBorder::free;
                    c.sigma_init = 4;
                }),
        changed("ExactSearch", bumps, 1, 40,
                [](MeshConfig& c) {
                    c.ssr = 0;
                    c.crr = 1;
                }),
        changed("AlwaysTheNewestPositions", bumps, 1, 40, [](MeshConfig& c) { c.prr = 1; }),
        changed("BatchesThatARefreshCuts", bumps, 1, 40,
                [](MeshConfig& c) {
                    c.prr = 7;
                    c.crr = 16;
                }),
        changed("BatchesThatGrow", bumps_density(101, 99), 2, 40,
                [](MeshConfig& c) {
                    c.spacing_px = 3;
                    c.prr = 2;
                    c.prr_final = 40;
                    c.crr = 9;
                }),
        changed("BatchesThatShrink", bumps, 1, 40,
                [](MeshConfig& c) {
                    c.prr = 12;
                    c.prr_final = 1;
                }),
        changed("UnlimitedSearchOnStaleLists", noise_density(60, 48, 7), 1, 40,
                [](MeshConfig& c) {
                    c.ssr = 0;
                    c.crr = 50;
                    c.co = 7;
                }),
        changed("NarrowSearchLosesPoints", noise_density(60, 48, 8), 1, 30,
                [](MeshConfig& c) {
                    c.ssr = 1;
                    c.co = 2;
                    c.crr = 1000;
                    c.spacing_px = 9;
                }),
        changed("FoldsOfAFreeBorderAreRepaired", bumps_density(101, 99), 3, 12,
                [](MeshConfig& c) {
                    c.spacing_px = 2;
                    c.prr = 1;
                    c.border = MeshBorder::free;
                }),
        changed("ManyDrawsACell", bumps, 1, 30, [](MeshConfig& c) { c.delta = 23.5; }),
        changed("DrawsByTheThousand", bumps, 1, 3, [](MeshConfig& c) { c.delta = 1000; }),
        changed("DrawsByTheThousandEverywhere", flat_density(60, 48), 1, 2,
                [](MeshConfig& c) { c.delta = 1000; }),
        changed("FractionalDelta", bumps, 1, 80, [](MeshConfig& c) { c.delta = 0.37; }),
        changed("PixelCells", noise_density(30, 24, 1), 1, 20,
                [](MeshConfig& c) {
                    c.co = 1;
                    c.delta = 0.5;
                    c.ssr = 4;
                }),
        changed("OneCell", bumps, 1, 60, [](MeshConfig& c) { c.co = 64; }),
        changed("WideSeed", bumps, 1, 40, [](MeshConfig& c) { c.seed = 0xFEDCBA9876543210u; }),
        changed("HalfLearningRate", bumps, 1, 40, [](MeshConfig& c) { c.alpha_init = 0.5; }),
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
