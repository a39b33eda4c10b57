// Vertex attributes and indices as arrays of small integers, as KHR_mesh_quantization allows them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "exporters/compression/draco_plan.h"

namespace hexrelief {

enum class ComponentType { int8, uint8, int16, uint16, float32 };

// One attribute of all vertices, as it lies in a buffer. Bytes between the components and the stride are 0.
struct VertexStream {
    std::vector<std::uint8_t> bytes;
    std::size_t count = 0, stride = 0;  // a multiple of 4
    int components = 3;
    ComponentType type = ComponentType::float32;
    bool normalized = false;
    bool octahedral = false;        // bytes are still to pass meshoptimizer's octahedral filter
    std::vector<double> low, high;  // of positions: of the components as stored
};

struct QuantizedMesh {
    VertexStream positions, normals, texcoords;  // count 0 = not there
    std::vector<std::uint32_t> indices;
    FileTransform transform;
    std::array<double, 2> texcoord_scale = {1, 1};
};

// The grid that positions lie on; none if 16 bits are too few for it, and they stay floats.
std::optional<Grid<3>> position_grid(const TexturedMesh& textured, const Calibration* camera,
                                     const ExportConfig& config, bool meshopt);

// The smallest types that keep the tolerances, 32-bit floats where 16 bits are too few. For meshopt, normals
// are octahedral, vertices are in the order of their first use, and triangles in the order that its index
// coder compresses best.
QuantizedMesh quantize_mesh(const TexturedMesh& textured, const Calibration* camera,
                            const ExportConfig& config, bool meshopt);

}  // namespace hexrelief
