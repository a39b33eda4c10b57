// Encodes Draco meshes, and decodes them, for tests of what readers get.
#pragma once

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "exporters/compression/draco_codec.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::exporters {

inline DracoMesh encode_draco(const SurfaceMesh& mesh, const DracoQuantisation& quantisation,
                              int threads = 1) {
    const auto values = [&] { return DracoValues{&mesh, &quantisation}; };
    return encode_draco(mesh, quantisation.level, values, threads);
}

struct DracoGeometry {
    std::vector<Vec3f> positions;  // dequantised
    std::vector<Triangle> triangles;
};

// Adds a failure and returns nothing if the bytes are no mesh.
inline DracoGeometry decode_draco(const std::vector<std::uint8_t>& bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    EXPECT_TRUE(decoded.ok()) << decoded.status().error_msg_string();
    if (!decoded.ok()) return {};
    const draco::Mesh& mesh = *decoded.value();
    const draco::PointAttribute& positions = *mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    DracoGeometry out;
    for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
        float p[3];
        EXPECT_TRUE((positions.ConvertValue<float, 3>(positions.mapped_index(draco::PointIndex(i)), p)));
        out.positions.push_back({p[0], p[1], p[2]});
    }
    for (std::uint32_t i = 0; i < mesh.num_faces(); ++i) {
        const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(i));
        out.triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
    }
    return out;
}

}  // namespace hexrelief::exporters
