// The box in which Draco counts an attribute's cells, and what a decoder makes of it.
#pragma once

#include <array>

#include "exporters/compression/draco_codec.h"
#include "exporters/compression/draco_plan.h"

namespace draco {
class ExpertEncoder;
}

namespace hexrelief::exporters {

// A decoder gets origin + cell * range / (2^bits - 1), in floats.
struct DracoBox {
    int bits = 0;
    std::array<float, 3> origin = {};
    float range = 0;
};

// As Draco keeps it by itself, which is with six decimals, or exactly.
template <int N>
DracoBox box_of(const Grid<N>& grid, bool exactly);

// Makes Draco count the attribute's cells in the grid's box.
template <int N>
void set_box(draco::ExpertEncoder& encoder, int attribute, const Grid<N>& grid, bool exactly);

// The largest error in px of the positions that a decoder will find, as quantise_positions() counts it: seen
// by the camera, in x, in y and in disparity. Infinite or not a number where the box is none.
double position_error_px(const SurfaceMesh& mesh, const Calibration& camera, const Grid<3>& grid,
                         const FileTransform& transform, bool exactly);

// The same of texture coordinates, in px of a texture of that size.
double texcoord_error_px(const std::vector<Vec2f>& texcoords, int width, int height, const Grid<2>& grid,
                         bool exactly);

}  // namespace hexrelief::exporters
