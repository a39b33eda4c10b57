// Checks that grids keep their tolerance and are no finer than necessary, and that smoothing
// never makes them worse.
#include <random>

#include "exporters/compression/draco_codec.h"
#include "exporters/compression/quantisation.h"
#include "pipeline/data/error.h"
#include "tests/exporters/draco_decode.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

// Returns a mesh of noisy vertices near and far, and far from the axis: x, y in -1 .. 1 m, depths of
// 0.8 to 20 m.
SurfaceMesh rough_mesh(int columns, int rows) {
    SurfaceMesh mesh = sample_mesh(columns, rows);
    std::mt19937 random(3);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        Vec3f& p = mesh.positions[i];
        const float depth =
            0.8f + 19.2f * (i % 7 == 0 ? 1 : 0.1f) * static_cast<float>(random() % 1000) / 1000;
        p = {p.x * depth, p.y * depth, -depth};
    }
    return mesh;
}

Calibration camera_of(double doffs_px) {
    Calibration camera = sample_camera();
    camera.focal_px = 500;
    camera.doffs_px = doffs_px;
    return camera;
}

std::array<double, 3> seen(const Calibration& camera, double x, double y, double z) {
    return {camera.cx - camera.focal_px * x / z, camera.cy + camera.focal_px * y / z,
            -camera.focal_px * camera.baseline_m / z - camera.doffs_px};
}

double worst_px(const SurfaceMesh& mesh, const Grid<3>& grid, const Calibration& camera) {
    double worst = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3f& p = mesh.positions[i];
        const auto wanted = seen(camera, p.x, p.y, p.z);
        const auto found = seen(camera, grid.value(i, 0), grid.value(i, 1), grid.value(i, 2));
        for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(wanted[k] - found[k]));
    }
    return worst;
}

class PositionGrid : public ::testing::TestWithParam<GridShape> {};

TEST_P(PositionGrid, KeepsTheToleranceAndUsesIt) {
    for (const SurfaceMesh& mesh : {sample_mesh(24, 18), rough_mesh(24, 18)})
        for (const double tolerance : {0.01, 0.1, 0.5}) {
            const Calibration camera = camera_of(tolerance * 30);
            const Grid<3> grid = quantise_positions(mesh, camera, tolerance, GetParam());
            const double worst = worst_px(mesh, grid, camera);
            EXPECT_LE(worst, tolerance);
            EXPECT_GT(worst, 0.8 * tolerance);  // a finer grid would be a waste
            for (const auto& cell : grid.cells)
                for (int k = 0; k < 3; ++k) {
                    EXPECT_GE(cell[k], 0);
                    EXPECT_LE(cell[k], grid.largest[k]);
                }
            EXPECT_LE(*std::max_element(grid.largest.begin(), grid.largest.end()), (1 << grid.bits()) - 1);
        }
}

TEST_P(PositionGrid, StepsAreEqualWhereTheyMustBe) {
    const Grid<3> grid = quantise_positions(rough_mesh(12, 9), camera_of(0), 0.1, GetParam());
    EXPECT_EQ(grid.step[0], grid.step[1]);
    EXPECT_EQ(grid.step[0] == grid.step[2], GetParam() == GridShape::cubic);
}

TEST_P(PositionGrid, RefusesWhatFloatsCannotHold) {
    EXPECT_THROW(quantise_positions(rough_mesh(12, 9), camera_of(0), 1e-5, GetParam()), Error);
}

INSTANTIATE_TEST_SUITE_P(Shapes, PositionGrid, ::testing::Values(GridShape::per_axis, GridShape::cubic));

TEST(TexcoordGrid, KeepsTheTolerance) {
    const SurfaceMesh mesh = sample_mesh(24, 18);
    for (const GridShape shape : {GridShape::per_axis, GridShape::cubic}) {
        const Grid<2> grid = quantise_texcoords(mesh.texcoords, 640, 480, 0.1, shape);
        for (std::size_t i = 0; i < mesh.texcoords.size(); ++i) {
            EXPECT_NEAR(grid.value(i, 0) * 640, mesh.texcoords[i].x * 640, 0.1);
            EXPECT_NEAR(grid.value(i, 1) * 480, mesh.texcoords[i].y * 480, 0.1);
        }
        EXPECT_EQ(grid.step[0] == grid.step[1], shape == GridShape::cubic);
    }
}

// A vertex with almost no disparity may be moved much nearer within the tolerance, so the grid need not
// extend to its depth.
TEST(PositionGridOfFarVertices, TakesFewBits) {
    SurfaceMesh mesh = sample_mesh(12, 9);
    const Calibration camera = camera_of(0);
    mesh.positions[40] = {1000, 2000, -50000};  // a disparity of 0.001 px
    const Grid<3> grid = quantise_positions(mesh, camera, 0.1, GridShape::per_axis);
    EXPECT_LE(worst_px(mesh, grid, camera), 0.1);
    EXPECT_LE(grid.bits(), 18);
    const Scene scene{&mesh, nullptr, "", "", &camera};
    const DracoPlan plan = plan_draco(untextured_mesh(scene, {}), &camera, {}, GridShape::per_axis);
    EXPECT_EQ(plan.transform.translation, FileTransform().translation);
}

// Returns the sum of |a + b - c - d| over all pairs of triangles with a common edge, by plain loops.
long long unevenness(const std::vector<Triangle>& triangles, const std::vector<std::int32_t>& cells) {
    long long sum = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::size_t j = i + 1; j < triangles.size(); ++j) {
            long long own = 0, other = 0, shared = 0;
            int common = 0;
            for (const std::uint32_t v : triangles[i]) {
                const bool both = std::count(triangles[j].begin(), triangles[j].end(), v) > 0;
                common += both;
                (both ? shared : own) += cells[v];
            }
            for (const std::uint32_t v : triangles[j])
                if (std::count(triangles[i].begin(), triangles[i].end(), v) == 0) other += cells[v];
            if (common == 2) sum += std::abs(shared - own - other);
        }
    return sum;
}

std::vector<CellRange> random_ranges(std::size_t count, int most_cells) {
    std::mt19937 random(5);
    std::vector<CellRange> ranges;
    for (std::size_t i = 0; i < count; ++i) {
        const auto low = static_cast<std::int32_t>(random() % 40) - 20;
        ranges.push_back({low, low + static_cast<std::int32_t>(random() % most_cells)});
    }
    return ranges;
}

TEST(GridSmoothing, TakesEachVertexsBestCellInTurn) {
    const SurfaceMesh mesh = sample_mesh(7, 6);
    const GridNeighbours neighbours(mesh.triangles, mesh.positions.size());
    for (const int most_cells : {2, 9, 60}) {
        const std::vector<CellRange> ranges = random_ranges(mesh.positions.size(), most_cells);
        std::vector<std::int32_t> cells = neighbours.smooth(ranges, 0);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const std::int32_t own = cells[i];
            const auto cost = [&](std::int32_t cell) {
                cells[i] = cell;
                return std::pair{unevenness(mesh.triangles, cells), std::abs(cell - own)};
            };
            std::int32_t best = own;
            for (std::int32_t cell = ranges[i].low; cell <= ranges[i].high; ++cell)
                if (cost(cell) < cost(best)) best = cell;
            cells[i] = best;
        }
        EXPECT_EQ(neighbours.smooth(ranges, 1), cells);
    }
}

TEST(GridSmoothing, LowersTheUnevennessWithinTheRanges) {
    const SurfaceMesh mesh = sample_mesh(9, 8);
    const std::vector<CellRange> ranges = random_ranges(mesh.positions.size(), 9);
    const GridNeighbours neighbours(mesh.triangles, mesh.positions.size());
    long long before = unevenness(mesh.triangles, neighbours.smooth(ranges, 0));
    for (const int sweeps : {1, 2, 3}) {
        const std::vector<std::int32_t> cells = neighbours.smooth(ranges, sweeps);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            EXPECT_GE(cells[i], ranges[i].low);
            EXPECT_LE(cells[i], ranges[i].high);
        }
        const long long now = unevenness(mesh.triangles, cells);
        EXPECT_LE(now, before);
        if (sweeps == 1) {
            EXPECT_LT(now, before);
        }
        before = now;
    }
}

// Returns the largest error in px of the values that Draco returns.
double worst_decoded_px(const SurfaceMesh& mesh, const Calibration& camera, GridShape shape,
                        double tolerance_px) {
    const Scene scene{&mesh, nullptr, "", "", &camera};
    ExportConfig config{.tolerance_px = tolerance_px};
    const DracoPlan plan = plan_draco(untextured_mesh(scene, config), &camera, config, shape);
    const DracoGeometry back = decode_draco(encode_draco(plan.mesh, plan.quantisation).bytes);
    EXPECT_EQ(back.positions.size(), mesh.positions.size());
    const auto& [shift, scale] = plan.transform;
    double worst = 0;
    for (const Vec3f& p : back.positions) {
        const auto at =
            seen(camera, shift[0] + scale[0] * p.x, shift[1] + scale[1] * p.y, shift[2] + scale[2] * p.z);
        double nearest = INFINITY;
        for (const Vec3f& given : mesh.positions) {
            const auto wanted = seen(camera, given.x, given.y, given.z);
            nearest = std::min(nearest, std::max({std::abs(at[0] - wanted[0]), std::abs(at[1] - wanted[1]),
                                                  std::abs(at[2] - wanted[2])}));
        }
        worst = std::max(worst, nearest);
    }
    return worst;
}

TEST(DracoPlan, DecodedPositionsKeepTheTolerance) {
    for (const GridShape shape : {GridShape::per_axis, GridShape::cubic})
        for (const double tolerance : {0.01, 0.1, 1.0})
            EXPECT_LE(worst_decoded_px(rough_mesh(24, 18), camera_of(3), shape, tolerance), tolerance);
}

// The six decimals of Draco's default are not enough for small scenes.
TEST(DracoPlan, SmallScenesKeepTheToleranceToo) {
    for (const float scale : {1e-3f, 1e-5f, 1e-10f, 1e-30f}) {
        SurfaceMesh mesh = rough_mesh(12, 9);
        for (Vec3f& p : mesh.positions) p = {p.x * scale, p.y * scale, p.z * scale};
        Calibration camera = camera_of(0);
        camera.baseline_m *= scale;
        for (const GridShape shape : {GridShape::per_axis, GridShape::cubic})
            EXPECT_LE(worst_decoded_px(mesh, camera, shape, 0.1), 0.1) << scale;
    }
}

// Refused even for denormal floats, which have less than 24 bits.
TEST(DracoPlan, RefusesWhatADecoderWouldNotFindAgain) {
    SurfaceMesh mesh = sample_mesh(12, 9);
    for (Vec3f& p : mesh.positions) p = {p.x * 1e-40f, p.y * 1e-40f, p.z * 1e-40f};
    Calibration camera = camera_of(0);
    camera.baseline_m *= 1e-40;
    EXPECT_THROW(worst_decoded_px(mesh, camera, GridShape::cubic, 0.1), Error);
}

TEST(DracoPlan, GivenBitsWin) {
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Calibration camera = sample_camera();
    const Scene scene{&mesh, nullptr, "", "", &camera};
    ExportConfig config{.draco = {.position_bits = 9, .normal_bits = 5}};
    const DracoPlan plan = plan_draco(untextured_mesh(scene, config), &camera, config, GridShape::per_axis);
    EXPECT_FALSE(plan.quantisation.positions);
    EXPECT_EQ(plan.quantisation.position_bits, 9);
    EXPECT_EQ(plan.quantisation.normal_bits, 5);
    EXPECT_EQ(plan.transform.scale, FileTransform().scale);
}

TEST(DracoPlan, CoarserTolerancesTakeFewerBytes) {
    const SurfaceMesh mesh = rough_mesh(40, 30);
    const Calibration camera = camera_of(0);
    const Scene scene{&mesh, nullptr, "", "", &camera};
    std::size_t before = 0;
    for (const double tolerance : {1.0, 0.3, 0.1, 0.03}) {
        ExportConfig config{.tolerance_px = tolerance};
        const DracoPlan plan =
            plan_draco(untextured_mesh(scene, config), &camera, config, GridShape::per_axis);
        const std::size_t bytes = encode_draco(plan.mesh, plan.quantisation).bytes.size();
        EXPECT_GT(bytes, before);
        before = bytes;
    }
}

}  // namespace
}  // namespace hexrelief::exporters
