// How the honeycomb cells share the density: a histogram.
#pragma once

#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::pictures {

// Shares of the weights (>= 0) in bins of W_k / mean, each 0.05 wide: bin i is centred at 0.05 i, the last
// one (2) holds all that is larger. Empty where there is no weight or all are 0.
std::vector<double> weight_shares(const std::vector<double>& weights);

// The bins as bars from 0 (left) to 2 (right) times the mean; lines stand at 0.5, 1 (red) and 1.5. A bar's
// height goes with the square root of its share, so that single cells show. 820 x 400 px.
Image weights_picture(const std::vector<double>& weights);

}  // namespace hexrelief::pictures
