// Things that moved between the two pictures.
#pragma once

#include "pipeline/alignment/estimate.h"

namespace hexrelief::alignment {

// Neighbouring matches that shift alike, but across the rows of the aligned pair: no camera explains them.
// What moves along the rows cannot be told from depth.
struct Movers {
    int points = 0;
    Point middle =
        {};  // the median of their places in the first picture, px of the matches' pictures as given
};

// Returns the movers among an estimate's matches; 0 points if they are fewer than 8 or 2 % of the matches,
// which chance and repeated patterns give.
Movers find_movers(const Estimate& estimate);

}  // namespace hexrelief::alignment
