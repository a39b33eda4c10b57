// The box of a grid in Draco's own quantisation, and the values that a decoder returns for it.
#pragma once

#include <array>

#include "exporters/compression/draco_codec.h"

namespace draco {
class ExpertEncoder;
}

namespace hexrelief::exporters {

// A decoder returns origin + cell * range / (2^bits - 1), computed in floats.
struct DracoBox {
    int bits = 0;
    std::array<float, 3> origin = {};
    float range = 0;
};

// Returns the grid's box, exactly or with origin and range rounded to six decimals, as Draco
// writes them by itself.
template <int N>
DracoBox box_of(const Grid<N>& grid, bool exactly);

// Makes Draco quantise the attribute on the grid.
template <int N>
void set_box(draco::ExpertEncoder& encoder, int attribute, const Grid<N>& grid, bool exactly);

// Returns the largest error, in px, of the positions that a decoder will return; measured as by
// quantise_positions(): as seen by the camera, in x, in y and in disparity. Infinite or NaN if
// the box is invalid.
double position_error_px(const SurfaceMesh& mesh, const Calibration& camera, const Grid<3>& grid,
                         const FileTransform& transform, bool exactly);

// Returns the largest error of texture coordinates, in px of a texture of that size. Infinite if
// the box is invalid.
double texcoord_error_px(const std::vector<Vec2f>& texcoords, int width, int height, const Grid<2>& grid,
                         bool exactly);

}  // namespace hexrelief::exporters
