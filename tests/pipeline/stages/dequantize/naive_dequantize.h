// The method of pipeline/stages/dequantize in plain loops over the energy's terms.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages::naive {

DisparityMap dequantize(const DisparityMap& map, double quantum_px);

}  // namespace hexrelief::stages::naive
