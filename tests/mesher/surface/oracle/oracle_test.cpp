// Tests the surface stage against an oracle that shares no code with it, on made-up scenes. The environment
// variable HEXRELIEF_ORACLE_SCENES sets their number.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "mesher/surface/cut_disparity_mesh.h"
#include "surface_oracle.h"
#include "surface_scenes.h"

namespace hexrelief::surface::oracle {
namespace {

constexpr double kPosition_px = 1e-4, kDisparity_px = 1e-3;

// Returns the surface stage's result for a scene, in the oracle's form.
Mesh production_mesh(const Scene& scene, int threads) {
    SurfaceConfig config;
    config.discontinuities = scene.config.bridge ? Discontinuities::bridge : Discontinuities::cut;
    config.least_discontinuity_px = scene.config.least_discontinuity_px;
    config.split_rounds = scene.config.split_rounds;
    config.silhouette_inset_px = scene.config.inset_px;
    const DisparityMesh mesh = hexrelief::surface::cut_disparity_mesh(
        {&scene.lattice, &scene.map, scene.background_px}, config, threads);
    return {mesh.points, mesh.disparities, mesh.triangles};
}

double largest_move(const Mesh& a, const Mesh& b) {
    double largest = 0;
    for (std::size_t v = 0; v < a.points.size(); ++v)
        largest = std::max({largest, std::fabs(double(a.points[v].x) - b.points[v].x),
                            std::fabs(double(a.points[v].y) - b.points[v].y)});
    return largest;
}

double largest_error(const Mesh& a, const Mesh& b) {
    double largest = 0;
    for (std::size_t v = 0; v < a.disparities.size(); ++v)
        largest = std::max(largest, std::fabs(double(a.disparities[v]) - b.disparities[v]));
    return largest;
}

// Returns a description of the first difference; empty if the meshes agree.
std::string difference_of(const Mesh& mesh, const Mesh& expected) {
    if (mesh.triangles.size() != expected.triangles.size())
        return std::to_string(mesh.triangles.size()) + " triangles, not " +
               std::to_string(expected.triangles.size());
    if (mesh.points.size() != expected.points.size() || mesh.disparities.size() != expected.points.size())
        return std::to_string(mesh.points.size()) + " vertices, not " +
               std::to_string(expected.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (mesh.triangles[t] != expected.triangles[t]) return "another triangle " + std::to_string(t);
    const double move = largest_move(mesh, expected), error = largest_error(mesh, expected);
    if (!(move <= kPosition_px)) return "vertices up to " + std::to_string(move) + " px off";
    if (!(error <= kDisparity_px)) return "disparities up to " + std::to_string(error) + " px off";
    return "";
}

Mesh oracle_mesh(const Scene& scene) {
    return cut_disparity_mesh(scene.lattice, scene.map, scene.background_px, scene.config);
}

TEST(SurfaceOracle, AgreesOnMadeUpScenes) {
    const char* const asked = std::getenv("HEXRELIEF_ORACLE_SCENES");
    const int scenes = asked ? std::atoi(asked) : 200;
    std::size_t triangles = 0;
    for (int number = 0; number < scenes; ++number) {
        const Scene scene = make_scene(number);
        const Mesh expected = oracle_mesh(scene);
        EXPECT_EQ(difference_of(production_mesh(scene, 1 + number % 3), expected), "") << scene.name;
        triangles += expected.triangles.size();
    }
    EXPECT_GT(triangles, 100u * static_cast<std::size_t>(scenes)) << "scenes that hardly show anything";
}

// The comparison above must be able to fail.
TEST(SurfaceOracle, DifferencesAreNoticed) {
    const Mesh mesh = oracle_mesh(make_scene(2));
    ASSERT_GT(mesh.triangles.size(), 10u);
    EXPECT_EQ(difference_of(mesh, mesh), "");
    Mesh moved = mesh, risen = mesh, turned = mesh, shorter = mesh;
    moved.points[3].y += 2e-4f;
    risen.disparities[3] += 2e-3f;
    std::rotate(turned.triangles[2].begin(), turned.triangles[2].begin() + 1, turned.triangles[2].end());
    shorter.triangles.pop_back();
    for (const Mesh& other : {moved, risen, turned, shorter}) EXPECT_NE(difference_of(other, mesh), "");
}

// Shared code would hide shared bugs.
TEST(SurfaceOracle, IncludesNothingOfTheMesher) {
    int files = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(HEXRELIEF_SOURCE_DIR "/tests/mesher/surface/oracle")) {
        if (entry.path().filename() == "oracle_test.cpp" || entry.path().extension() == ".md") continue;
        ++files;
        std::ifstream in(entry.path());
        for (std::string line; std::getline(in, line);)
            if (line.starts_with("#include \"") && line.find('/') != std::string::npos) {
                EXPECT_TRUE(line.starts_with("#include \"pipeline/data/")) << entry.path() << ": " << line;
            }
    }
    EXPECT_GT(files, 10);
}

}  // namespace
}  // namespace hexrelief::surface::oracle
