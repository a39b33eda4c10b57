#include "exporters/inspect/draco_decode.h"

#include <gtest/gtest.h>

#include <cmath>

#include "exporters/compression/draco_codec.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::inspect {
namespace {

TEST(DracoDecode, GivesBackPositionsAndTriangles) {
    const SurfaceMesh mesh = exporters::sample_mesh(12, 9);
    exporters::DracoQuantisation config;
    config.position_bits = 16;
    const DracoGeometry back = decode_draco(exporters::encode_draco(mesh, config).bytes, "sample");
    ASSERT_EQ(back.positions.size(), mesh.positions.size());
    ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
    const auto area_sum = [](const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles) {
        double sum = 0;  // as seen from the camera; sensitive to wrong corners and reversed triangles
        for (const Triangle& t : triangles) {
            const Vec3f &a = positions[t[0]], &b = positions[t[1]], &c = positions[t[2]];
            sum += double(b.x - a.x) * (c.y - a.y) - double(b.y - a.y) * (c.x - a.x);
        }
        return sum;
    };
    const double given = area_sum(mesh.positions, mesh.triangles);
    EXPECT_NEAR(area_sum(back.positions, back.triangles), given, 1e-3 * std::fabs(given));
}

TEST(DracoDecode, SaysWhatCannotBeRead) {
    const std::vector<std::uint8_t> whole = exporters::encode_draco(exporters::sample_mesh(6, 5), {}).bytes;
    const auto refused = [](const std::vector<std::uint8_t>& bytes) {
        try {
            decode_draco(bytes, "some name");
        } catch (const Error& e) {
            return e.kind() == ErrorKind::input &&
                   std::string(e.what()).find("some name") != std::string::npos;
        }
        return false;
    };
    EXPECT_TRUE(refused({}));
    EXPECT_TRUE(refused({1, 2, 3}));
    EXPECT_TRUE(refused({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2)}));
}

}  // namespace
}  // namespace hexrelief::inspect
