// Adds the left camera as a glTF camera.
#include <cmath>

#include "exporters/formats/gltf/gltf_parts.h"
#include "pipeline/data/bounds.h"

namespace hexrelief::exporters {

int add_camera(GltfParts& parts, const Calibration& camera, const SurfaceMesh& mesh) {
    using tinygltf::Value;
    tinygltf::Camera& out = parts.model.cameras.emplace_back();
    out.name = "left";
    out.type = "perspective";
    out.perspective.yfov = 2 * std::atan(0.5 * camera.height / camera.focal_px);
    out.perspective.aspectRatio = static_cast<double>(camera.width) / camera.height;
    // Wide enough for a viewer that moves about: ten times nearer and a hundred times farther.
    const Bounds bounds = bounds_of(mesh.positions);
    out.perspective.znear = 0.1 * -static_cast<double>(bounds.high.z);
    out.perspective.zfar = 100 * -static_cast<double>(bounds.low.z);
    out.extras =
        Value(Value::Object{{"focal_px", Value(camera.focal_px)},
                            {"principal_point_px", Value(Value::Array{Value(camera.cx), Value(camera.cy)})},
                            {"size_px", Value(Value::Array{Value(camera.width), Value(camera.height)})}});
    // Vertices are in the camera's frame, which is glTF's: the node needs no transform.
    tinygltf::Node& node = parts.model.nodes.emplace_back();
    node.name = "left camera";
    node.camera = static_cast<int>(parts.model.cameras.size()) - 1;
    return static_cast<int>(parts.model.nodes.size()) - 1;
}

}  // namespace hexrelief::exporters
