// The surface as compressed files hold it, against the files themselves.
#include "pipeline/job/tolerance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "exporters/compression/draco_plan.h"
#include "exporters/inspect/draco_decode.h"

namespace hexrelief::job {
namespace {

const Calibration kCamera{320, 160, 120, 0.16, 0, true, 320, 240};

// A wavy sheet in front of the camera, without any regularity that rounding could hide in.
SurfaceMesh wave() {
    SurfaceMesh mesh;
    constexpr int kSide = 12;
    for (int i = 0; i < kSide * kSide; ++i) {
        const double x = 20.3 * (i % kSide) + 3 * std::sin(i), y = 17.7 * (i / kSide) + 2 * std::cos(3 * i);
        const double disparity = 20 + 8 * std::sin(0.05 * x) + 3 * std::cos(0.07 * y);
        const double depth = kCamera.focal_px * kCamera.baseline_m / disparity;
        mesh.image_points.push_back({float(x), float(y)});
        mesh.disparities.push_back(float(disparity));
        mesh.positions.push_back({float((x - kCamera.cx) * depth / kCamera.focal_px),
                                  float(-(y - kCamera.cy) * depth / kCamera.focal_px), float(-depth)});
    }
    for (std::uint32_t i = 0; i + kSide < kSide * kSide; ++i)
        if (i % kSide + 1 < kSide) {
            mesh.triangles.push_back({i, i + kSide, i + 1});
            mesh.triangles.push_back({i + 1, i + kSide, i + kSide + 1});
        }
    return mesh;
}

using Points = std::vector<std::array<double, 3>>;  // x, y, disparity, sorted by cells of 2 px

Points sorted(Points points) {
    const auto cell = [](double value) { return std::lround(value / 2); };
    std::sort(points.begin(), points.end(), [&](const auto& a, const auto& b) {
        return std::pair(cell(a[1]), a[0]) < std::pair(cell(b[1]), b[0]);
    });
    return points;
}

Points decoded(const SurfaceMesh& mesh, const exporters::ExportConfig& config, exporters::GridShape shape) {
    exporters::TexturedMesh untextured;
    untextured.mesh = mesh;
    const exporters::DracoPlan plan = exporters::plan_draco(untextured, &kCamera, config, shape);
    Points points;
    for (const Vec3f& p :
         inspect::decode_draco(exporters::encode_draco(plan.mesh, plan.quantisation).bytes, "wave")
             .positions) {
        const auto& [scale, offset] = std::pair(plan.transform.scale, plan.transform.translation);
        const double x = p.x * scale[0] + offset[0], y = p.y * scale[1] + offset[1],
                     depth = -(p.z * scale[2] + offset[2]);
        points.push_back({x / depth * kCamera.focal_px + kCamera.cx,
                          -y / depth * kCamera.focal_px + kCamera.cy,
                          kCamera.focal_px * kCamera.baseline_m / depth});
    }
    return sorted(points);
}

TEST(AsWritten, IsWhatDracoReadsBack) {
    const SurfaceMesh mesh = wave();
    exporters::ExportConfig coarse;
    coarse.compression = exporters::Compression::draco;
    coarse.tolerance_px = 0.6;
    exporters::ExportConfig fixed = coarse;
    fixed.draco.position_bits = 7;
    for (const exporters::ExportConfig& config : {coarse, fixed})
        for (const char* path : {"a.drc", "a.glb"}) {
            const bool drc = std::string(path) == "a.drc";
            const SurfaceMesh seen = as_written(mesh, kCamera, config, {"b.obj", path});
            EXPECT_EQ(seen.triangles, mesh.triangles);
            Points ours;
            for (std::size_t i = 0; i < seen.disparities.size(); ++i)
                ours.push_back({seen.image_points[i].x, seen.image_points[i].y, seen.disparities[i]});
            ours = sorted(ours);
            const Points theirs =
                decoded(mesh, config, drc ? exporters::GridShape::cubic : exporters::GridShape::per_axis);
            ASSERT_EQ(ours.size(), theirs.size());
            double moved = 0;
            for (std::size_t i = 0; i < ours.size(); ++i)
                for (int k = 0; k < 3; ++k) {
                    EXPECT_NEAR(ours[i][k], theirs[i][k], 0.01) << path << " point " << i;
                    moved = std::max(moved, std::fabs(seen.disparities[i] - double(mesh.disparities[i])));
                }
            EXPECT_GT(moved, 0.1) << "coarse enough to tell from the surface";
        }
}

TEST(AsWritten, IsTheSurfaceWhereNothingIsCompressed) {
    const SurfaceMesh mesh = wave();
    const SurfaceMesh seen = as_written(mesh, kCamera, {}, {"a.obj", "a.ply", "a.glb"});
    EXPECT_EQ(seen.disparities, mesh.disparities);
    EXPECT_FALSE(is_compressed("a.glb", {}));
    EXPECT_TRUE(is_compressed("a.drc", {}));
    exporters::ExportConfig meshopt;
    meshopt.compression = exporters::Compression::meshopt;
    EXPECT_TRUE(is_compressed("a.gltf", meshopt));
    EXPECT_FALSE(is_compressed("a.obj", meshopt));
}

}  // namespace
}  // namespace hexrelief::job
