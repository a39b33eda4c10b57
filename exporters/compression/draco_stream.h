// The smallest Draco bitstream of a mesh.
#pragma once

#include <functional>

#include "exporters/compression/draco_codec.h"

namespace draco {
class Mesh;
}

namespace hexrelief::exporters {

// Waits until the mesh's attributes hold their values, and says how finely these are kept: on the grids that
// they lie on. Any thread may call it, as often as it likes.
using DracoValuesReady = std::function<const DracoQuantisation&()>;

// Encodes by Edgebreaker, positions first. The triangles, half of the work, are encoded before `ready` is
// asked for the values. At level 10 normals and texture coordinates each get the prediction, of all that
// Draco knows for them, that takes the fewest bytes. Everything in the result is what a decoder will find.
// The bytes are the same for any number of threads; a second one halves the time, five take two thirds of
// that. Throws Error(output) where libdraco refuses the mesh.
DracoMesh write_draco_stream(const draco::Mesh& mesh, int level, const DracoValuesReady& ready, int threads);

}  // namespace hexrelief::exporters
