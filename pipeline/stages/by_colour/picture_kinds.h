// What a pair's pictures are: some limits depend on it.
#pragma once

namespace hexrelief::stages {

// rectified: of a calibrated camera. photographs: of any camera; their points say where it stood.
enum class Pictures { rectified, photographs };

}  // namespace hexrelief::stages
