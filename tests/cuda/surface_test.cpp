// Tests that the meshes of the CPU and of CUDA have the same bytes.
#include <cmath>
#include <random>

#include "pipeline/data/error.h"
#include "tests/cuda/cuda_case.h"
#include "tests/mesher/surface/made_up_scene.h"

namespace hexrelief::testing_cuda {
namespace {

using surface::Scene;

template <typename T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same_mesh(const surface::DisparityMeshInput& input, const SurfaceConfig& config) {
    const DisparityMesh cpu = surface::cut_disparity_mesh(input, config, 2);
    const DisparityMesh cuda = shared_mesher()->cut_disparity_mesh(input, config);
    EXPECT_GT(shared_mesher()->figures().surface_s, 0) << "the device did nothing";
    EXPECT_TRUE(same(cpu.points, cuda.points)) << cpu.points.size() << " " << cuda.points.size();
    EXPECT_TRUE(same(cpu.disparities, cuda.disparities));
    EXPECT_TRUE(same(cpu.triangles, cuda.triangles)) << cpu.triangles.size() << " " << cuda.triangles.size();
}

struct NamedScene {
    const char* name;
    surface::DisparityAt disparity;
    float background_px = 0;
};
void PrintTo(const NamedScene& scene, std::ostream* out) {
    *out << scene.name;
}

double hashed(double x, double y) {
    return std::mt19937(static_cast<unsigned>(1000 * x + 7 * y))() / 4294967296.0;
}

std::vector<NamedScene> scenes() {
    const double nothing = std::nan("");
    return {
        {"Plane", [](double x, double y) { return 20 + 0.1 * x + 0.05 * y; }},
        {"Disc", [](double x, double y) { return surface::disc(x, y, 40, 12); }},
        {"DiscOnBackground", [](double x, double y) { return surface::disc(x, y, 40, 12); }, 20},
        {"LowSteps", [](double x, double y) { return 20 + std::floor(x / 9) + std::floor(y / 13); }},
        {"Floor", [](double x, double y) { return 5 + 0.8 * y + 0.02 * x; }},
        {"Stripes", [](double x, double) { return static_cast<int>(x) % 5 == 0 ? 30.0 : 10.0; }},
        {"OnePixelWide", [](double x, double y) { return static_cast<int>(x + y) % 2 ? 30.0 : 10.0; }},
        {"Noise", [](double x, double y) { return 5 + 50 * hashed(x, y); }},
        {"NoisyPlane", [](double x, double y) { return 20 + 0.1 * x + hashed(x, y); }},
        {"Holes",
         [=](double x, double y) { return hashed(x, y) < 0.4 ? nothing : surface::disc(x, y, 40, 12); }},
        {"LargeHoles",
         [=](double x, double y) {
             return std::sin(x / 6) * std::sin(y / 5) > 0.5 ? nothing : surface::disc(x, y, 40, 12 + x / 30);
         }},
        {"Nothing", [=](double, double) { return nothing; }},
        {"AllBackground", [](double, double) { return 3.0; }, 10},
        {"OnePixel",
         [](double x, double y) { return std::abs(x - 70.5) + std::abs(y - 50.5) < 0.1 ? 30.0 : 3.0; }, 10},
    };
}

class SurfaceEquality : public ::testing::TestWithParam<NamedScene> {};

TEST_P(SurfaceEquality, Cut) {
    HEXRELIEF_NEEDS_DEVICE();
    surface::Scene scene(GetParam().disparity);
    scene.background_px = GetParam().background_px;
    expect_same_mesh({&scene.mesh, &scene.map, scene.background_px}, scene.config);
}

TEST_P(SurfaceEquality, CutWithInset) {
    HEXRELIEF_NEEDS_DEVICE();
    surface::Scene scene(GetParam().disparity);
    scene.config.silhouette_inset_px = 0.3;
    scene.config.split_rounds = 5;
    expect_same_mesh({&scene.mesh, &scene.map, GetParam().background_px}, scene.config);
}

TEST_P(SurfaceEquality, Bridged) {
    HEXRELIEF_NEEDS_DEVICE();
    surface::Scene scene(GetParam().disparity);
    scene.config.discontinuities = Discontinuities::bridge;
    scene.config.split_rounds = 1;
    expect_same_mesh({&scene.mesh, &scene.map, GetParam().background_px}, scene.config);
}

TEST_P(SurfaceEquality, CoarseAndFineLattices) {
    HEXRELIEF_NEEDS_DEVICE();
    surface::Scene scene(GetParam().disparity);
    for (const double spacing : {2.5, 4.0, 11.0, 40.0}) {
        scene.mesh = surface::covering(mesher::regular_lattice(scene.map.width, scene.map.height, spacing));
        expect_same_mesh({&scene.mesh, &scene.map, GetParam().background_px}, scene.config);
    }
}

INSTANTIATE_TEST_SUITE_P(Cuda, SurfaceEquality, ::testing::ValuesIn(scenes()),
                         [](const auto& i) { return std::string(i.param.name); });

// Small enough for the sanitizers.
TEST(CudaSmall, MeshOfADisc) {
    HEXRELIEF_NEEDS_DEVICE();
    surface::Scene scene([](double x, double y) {
        return hashed(x, y) < 0.02 ? std::nan("") : surface::disc(x, y, 40, 12 + 0.1 * y);
    });
    scene.config.silhouette_inset_px = 0.3;
    expect_same_mesh({&scene.mesh, &scene.map, 8}, scene.config);
}

TEST(CudaSurface, TinyMaps) {
    HEXRELIEF_NEEDS_DEVICE();
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 9}, {3, 3}, {7, 5}, {33, 2}}) {
        DisparityMap map{width, height, {}};
        for (int i = 0; i < width * height; ++i) map.values.push_back(static_cast<float>(1 + 7 * (i % 3)));
        const HexMesh2D mesh = mesher::regular_lattice(width, height, 2);
        expect_same_mesh({&mesh, &map, 0}, {});
    }
}

// More vertices than the first capacity: the stage runs again with more.
TEST(CudaSurface, FarMoreVerticesThanTheLattice) {
    HEXRELIEF_NEEDS_DEVICE();
    surface::Scene scene([](double x, double y) {
        return (static_cast<int>(x / 5) + static_cast<int>(y / 5)) % 2 ? 30.0 : 10.0;
    });
    const DisparityMap& map = scene.map;
    scene.mesh = surface::covering(mesher::regular_lattice(map.width, map.height, 8));
    const std::size_t vertices = scene.mesh.positions.size(),
                      points = surface::cut_disparity_mesh({&scene.mesh, &map, 0}, {}, 2).points.size();
    ASSERT_GT(points, 1024 + 3 * vertices / 2);
    expect_same_mesh({&scene.mesh, &map, 0}, {});
}

// The meshes of the default, whose triangles are of all sizes.
TEST(CudaSurface, SolvedMeshes) {
    HEXRELIEF_NEEDS_DEVICE();
    for (const DensityMap& density :
         {testing_mesher::bumps_density(457, 379), testing_mesher::noise_density(333, 290, 3)}) {
        const DisparityMap map = varied_map(density);
        const HexMesh2D solved = mesher::solve_mesh(density, {}, 2, {});
        for (const float background_px : {0.0f, 18.0f}) expect_same_mesh({&solved, &map, background_px}, {});
    }
}

// Maps that the mesh stage left on the device, and one that another map has replaced.
TEST(CudaSurface, MapOnTheDevice) {
    HEXRELIEF_NEEDS_DEVICE();
    for (const unsigned seed : {3, 4}) {
        const DensityMap density = testing_mesher::noise_density(133, 90, seed);
        const DisparityMap original = varied_map(density);
        DisparityMap map = original;
        shared_mesher()->expect_map(map);
        const HexMesh2D solved = shared_mesher()->solve(density, {}, {});
        const surface::DisparityMeshInput input{&solved, &map, 0};
        expect_same_mesh(input, {});
        std::fill(map.values.begin(), map.values.end(), 1.0f);
        const DisparityMesh kept = shared_mesher()->cut_disparity_mesh(input, {});
        const DisparityMesh expected = surface::cut_disparity_mesh({&solved, &original, 0}, {}, 2);
        EXPECT_TRUE(same(kept.points, expected.points) && same(kept.disparities, expected.disparities) &&
                    same(kept.triangles, expected.triangles));
        EXPECT_FALSE(same(kept.disparities, surface::cut_disparity_mesh(input, {}, 2).disparities));
        expect_same_mesh({&solved, &original, 0}, {});
        shared_mesher()->solve(density, {}, {});
        expect_same_mesh(input, {});
    }
}

TEST(CudaRepeats, SurfacesAreTheSameEveryTime) {
    HEXRELIEF_NEEDS_DEVICE();
    const DensityMap density = testing_mesher::bumps_density(457, 379);
    const DisparityMap map = varied_map(density);
    const HexMesh2D solved = mesher::solve_mesh(density, {}, 2, {});
    const surface::DisparityMeshInput input{&solved, &map, 18};
    const DisparityMesh first = shared_mesher()->cut_disparity_mesh(input, {});
    const char* repeats = std::getenv("HEXRELIEF_REPEATS");
    for (int i = 0; i < (repeats ? std::atoi(repeats) : 5); ++i) {
        const DisparityMesh again = shared_mesher()->cut_disparity_mesh(input, {});
        ASSERT_TRUE(same(first.points, again.points) && same(first.disparities, again.disparities) &&
                    same(first.triangles, again.triangles))
            << "run " << i;
    }
}

TEST(CudaSurface, ErrorsAreThoseOfTheCpu) {
    HEXRELIEF_NEEDS_DEVICE();
    surface::Scene scene([](double, double) { return 5.0; });
    scene.mesh.positions.pop_back();
    EXPECT_THROW(shared_mesher()->cut_disparity_mesh({&scene.mesh, &scene.map, 0}, {}), Error);
}

}  // namespace
}  // namespace hexrelief::testing_cuda
