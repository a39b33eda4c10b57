// The surface as compressed files hold it, against the files themselves.
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "exporters/compression/draco_codec.h"
#include "exporters/exporter.h"
#include "exporters/viewer/html_exporter.h"
#include "pipeline/job/outputs.h"
#include "tests/exporters/draco_decode.h"
#include "tests/pipeline/process.h"

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
         exporters::decode_draco(exporters::encode_draco(plan.mesh, plan.quantisation).bytes).positions) {
        const auto& [scale, offset] = std::pair(plan.transform.scale, plan.transform.translation);
        const double x = p.x * scale[0] + offset[0], y = p.y * scale[1] + offset[1],
                     depth = -(p.z * scale[2] + offset[2]);
        points.push_back({x / depth * kCamera.focal_px + kCamera.cx,
                          -y / depth * kCamera.focal_px + kCamera.cy,
                          kCamera.focal_px * kCamera.baseline_m / depth});
    }
    return sorted(points);
}

Points points_of(const SurfaceMesh& seen) {
    Points points;
    for (std::size_t i = 0; i < seen.disparities.size(); ++i)
        points.push_back({seen.image_points[i].x, seen.image_points[i].y, seen.disparities[i]});
    return sorted(points);
}

exporters::Scene scene_of(const SurfaceMesh& mesh) {
    exporters::Scene scene{&mesh, nullptr, "test", "{}", &kCamera};
    scene.image_width = kCamera.width;
    scene.image_height = kCamera.height;
    return scene;
}

std::string from_base64(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < text.size() && text[i] != '='; ++i) {
        bits = bits << 6 | static_cast<std::uint32_t>(digits.find(text[i]));
        if (i % 4 != 0) bytes += static_cast<char>(bits >> (6 - 2 * (i % 4)) & 255);
    }
    return bytes;
}

// The vertices of the mesh in a page, by meshoptimizer's decoder.
Points decoded_page(const std::string& page) {
    const std::size_t begin = page.find("id=\"glb\">") + 9;
    const std::string glb = from_base64(page.substr(begin, page.find('<', begin) - begin));
    std::uint32_t json_bytes = 0;
    std::memcpy(&json_bytes, glb.data() + 12, 4);
    const auto json = nlohmann::json::parse(glb.substr(20, json_bytes));
    const auto& nodes = json["nodes"];
    const auto& node =
        *std::find_if(nodes.begin(), nodes.end(), [](const auto& one) { return one.contains("mesh"); });
    const auto& accessor =
        json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<int>()];
    const auto& view =
        json["bufferViews"][accessor["bufferView"].get<int>()]["extensions"]["EXT_meshopt_compression"];
    const std::size_t count = view["count"], stride = view["byteStride"];
    std::vector<unsigned char> bytes(count * stride);
    const auto* const coded =
        reinterpret_cast<const unsigned char*>(glb.data()) + 28 + json_bytes + view.value("byteOffset", 0);
    EXPECT_EQ(meshopt_decodeVertexBuffer(bytes.data(), count, stride, coded, view["byteLength"]), 0);
    const int type = accessor["componentType"];  // 5121: bytes, 5123: of 16 bits, 5126: floats
    Points points;
    for (std::size_t i = 0; i < count; ++i) {
        std::array<double, 3> p;
        for (int k = 0; k < 3; ++k) {
            const unsigned char* const at = bytes.data() + i * stride;
            std::uint16_t whole = 0;
            float number = 0;
            std::memcpy(&whole, at + 2 * k, 2);
            if (type == 5126) std::memcpy(&number, at + 4 * k, 4);
            const double stored = type == 5121 ? at[k] : type == 5123 ? whole : number;
            p[k] = stored * (node.contains("scale") ? node["scale"][k].get<double>() : 1.0) +
                   (node.contains("translation") ? node["translation"][k].get<double>() : 0.0);
        }
        points.push_back({p[0] / -p[2] * kCamera.focal_px + kCamera.cx,
                          p[1] / p[2] * kCamera.focal_px + kCamera.cy,
                          kCamera.focal_px * kCamera.baseline_m / -p[2]});
    }
    return sorted(points);
}

TEST(AsWritten, IsWhatDracoReadsBack) {
    const SurfaceMesh mesh = wave();
    exporters::ExportConfig coarse{.compression = exporters::Compression::draco, .tolerance_px = 0.6};
    exporters::ExportConfig fixed = coarse;
    fixed.draco.position_bits = 7;
    for (const exporters::ExportConfig& config : {coarse, fixed})
        for (const char* path : {"a.drc", "a.glb"}) {
            const bool drc = std::string(path) == "a.drc";
            const SurfaceMesh seen = as_written(scene_of(mesh), config, {"b.obj", path});
            EXPECT_EQ(seen.triangles, mesh.triangles);
            const Points ours = points_of(seen);
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

// Both with the page's own tolerance, which costs few bytes where little is asked for, and with what is asked
// for.
TEST(AsWritten, IsWhatAPageHolds) {
    if (!exporters::has_viewer()) GTEST_SKIP() << "NOTE: " << exporters::kNoViewer;
    const SurfaceMesh mesh = wave();
    const test::TemporaryFolder folder;
    for (const double tolerance_px : {0.03, 0.6}) {
        exporters::ExportConfig config;
        config.compression = exporters::Compression::draco;  // of other files
        config.tolerance_px = tolerance_px;
        exporters::export_scene(scene_of(mesh), config, folder / "a.html");
        const Points ours = points_of(as_written(scene_of(mesh), config, {"b.obj", "a.html"}));
        const Points theirs = decoded_page(test::read_text(folder / "a.html"));
        ASSERT_EQ(ours.size(), theirs.size());
        double moved = 0;
        const Points exact = points_of(mesh);
        for (std::size_t i = 0; i < ours.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(ours[i][k], theirs[i][k], 1e-4) << "point " << i;
                moved = std::max(moved, std::fabs(exact[i][k] - theirs[i][k]));
            }
        EXPECT_GT(moved, 0.005) << "coarse enough to tell from the surface";
    }
}

TEST(AsWritten, IsTheSurfaceWhereNothingIsCompressed) {
    const SurfaceMesh mesh = wave();
    const SurfaceMesh seen = as_written(scene_of(mesh), {}, {"a.obj", "a.ply", "a.glb"});
    EXPECT_EQ(seen.disparities, mesh.disparities);
    EXPECT_FALSE(is_compressed("a.glb", {}));
    EXPECT_TRUE(is_compressed("a.drc", {}));
    exporters::ExportConfig meshopt;
    meshopt.compression = exporters::Compression::meshopt;
    EXPECT_TRUE(is_compressed("a.gltf", meshopt));
    EXPECT_FALSE(is_compressed("a.obj", meshopt));
    EXPECT_TRUE(is_compressed("a.html", {}));
}

}  // namespace
}  // namespace hexrelief::job
