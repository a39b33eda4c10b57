// Vertex attributes and indices as arrays of small integers, as KHR_mesh_quantization allows them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "exporters/compression/draco_codec.h"

namespace hexrelief::exporters {

enum class ComponentType { int8 = 5120, uint8, int16, uint16, float32 = 5126 };  // numbered as in glTF

// One attribute of all vertices, as it lies in a buffer. Padding bytes up to the stride are 0.
struct VertexStream {
    std::vector<std::uint8_t> bytes;
    std::size_t count = 0, stride = 0;  // stride in bytes, a multiple of 4
    int components = 3;
    ComponentType type = ComponentType::float32;
    bool normalized = false;
    bool octahedral = false;        // bytes have yet to pass meshoptimizer's octahedral filter
    std::vector<double> low, high;  // of positions: bounds of the components as stored
};

struct QuantizedMesh {
    VertexStream positions, normals, texcoords, provenance;  // count 0 = attribute is missing
    std::vector<std::uint32_t> indices;
    FileTransform transform;
    std::array<double, 2> texcoord_scale = {1, 1};
};

// Chooses the grid of the positions; none if 16 bits are too few for the grid, so that positions stay floats.
std::optional<Grid<3>> position_grid(const TexturedMesh& textured, const Calibration* camera,
                                     const ExportConfig& config, bool meshopt);

// Converts the mesh to the smallest types that keep the tolerances; 32-bit floats if 16 bits are too few.
// With meshopt, normals are octahedral, vertices are in the order of their first use, and triangles are in
// the order that meshoptimizer's index coder compresses best.
QuantizedMesh quantize_mesh(const TexturedMesh& textured, const Calibration* camera,
                            const ExportConfig& config, bool meshopt);

}  // namespace hexrelief::exporters
