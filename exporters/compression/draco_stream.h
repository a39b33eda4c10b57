// Writes the smallest Draco bitstream of a mesh.
#pragma once

#include <functional>

#include "exporters/compression/draco_codec.h"

namespace draco {
class Mesh;
}

namespace hexrelief::exporters {

// Waits until the mesh's attributes hold their values, and returns the quantisation on whose grids they lie.
// May be called from any thread, any number of times.
using DracoValuesReady = std::function<const DracoQuantisation&()>;

// Encodes by Edgebreaker, positions first. The triangles, half of the work, are encoded before `ready` is
// called for the values. At level 10 normals and texture coordinates each get the prediction, among those
// that Draco has for them, that takes the fewest bytes. All fields of the result describe the decoded mesh.
// The bytes are the same for any number of threads; two threads halve the time, five reduce it to a third.
// Throws Error(output) if libdraco refuses the mesh.
DracoMesh write_draco_stream(const draco::Mesh& mesh, int level, const DracoValuesReady& ready, int threads);

}  // namespace hexrelief::exporters
