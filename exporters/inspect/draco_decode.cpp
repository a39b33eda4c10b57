#include "exporters/inspect/draco_decode.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include <memory>
#include <new>
#include <stdexcept>

#include "pipeline/data/error.h"

namespace hexrelief::inspect {
namespace {

[[noreturn]] void fail(const std::string& name, const std::string& reason) {
    throw Error(ErrorKind::input, "cannot read '" + name + "' as a Draco mesh: " + reason);
}

std::unique_ptr<draco::Mesh> decode(const std::vector<std::uint8_t>& bytes, const std::string& name) {
    try {
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        draco::Decoder decoder;
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok()) fail(name, decoded.status().error_msg_string());
        return std::move(decoded).value();
    } catch (const std::bad_alloc&) {
    } catch (const std::length_error&) {
    }
    fail(name, "its header asks for more memory than there is");
}

}  // namespace

DracoGeometry decode_draco(const std::vector<std::uint8_t>& bytes, const std::string& name) {
    const std::unique_ptr<draco::Mesh> mesh = decode(bytes, name);
    const draco::PointAttribute* positions = mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
    if (!positions || positions->num_components() != 3) fail(name, "it has no positions in space");
    DracoGeometry out;
    out.positions.resize(mesh->num_points());
    for (std::uint32_t i = 0; i < mesh->num_points(); ++i) {
        float p[3];
        if (!positions->ConvertValue<float, 3>(positions->mapped_index(draco::PointIndex(i)), p))
            fail(name, "its positions are no numbers");
        out.positions[i] = {p[0], p[1], p[2]};
    }
    out.triangles.reserve(mesh->num_faces());
    for (std::uint32_t i = 0; i < mesh->num_faces(); ++i) {
        const draco::Mesh::Face& face = mesh->face(draco::FaceIndex(i));
        const Triangle t{face[0].value(), face[1].value(), face[2].value()};
        for (const std::uint32_t corner : t)
            if (corner >= out.positions.size()) fail(name, "a triangle has a corner that is not there");
        out.triangles.push_back(t);
    }
    return out;
}

}  // namespace hexrelief::inspect
