// The smallest Draco bitstream of a mesh.
#pragma once

#include "exporters/compression/draco_codec.h"

namespace draco {
class Mesh;
}

namespace hexrelief {

// Encodes by Edgebreaker, positions first. `quantisation` says how finely: its grids must be those that the
// mesh's values lie on. At level 10 normals and texture coordinates each get the prediction, of all that
// Draco knows for them, that takes the fewest bytes. Everything in the result is what a decoder will find.
// The bytes are the same for any number of threads; a second one halves the time, five take two thirds of
// that. Throws Error(output) where libdraco refuses the mesh.
DracoMesh write_draco_stream(const draco::Mesh& mesh, const DracoQuantisation& quantisation, int threads);

}  // namespace hexrelief
