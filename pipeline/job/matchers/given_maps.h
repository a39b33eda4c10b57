// Refines the maps that another matcher gave, and keeps of them what is right.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// Returns the left view's disparities, with their origins, by stages::refine_maps(). Of dense maps, pixels of
// another colour than their match are left out of that, and the given disparities stay where the refined ones
// are not better. They are at fault where the right view's map contradicts, because it sees something farther
// there, and where the match has another colour. A refined disparity is clearly better if it differs by more
// than 2 px and matches pixels that are clearly more alike. If that holds for more than 14 % of the pixels
// beside discontinuities, the given discontinuities are blurred or displaced: the refined disparities count
// near them, and at faults within 3 px of such pixels. Else they count at faults that they match clearly
// better, if these are more than 1 % of all pixels: true maps have some, too. What the right camera does not
// see stays as given otherwise. Throws as stages::refine_maps().
DisparityMap refine_given(const StereoPair& pair, const stages::ViewMaps& given,
                          const stages::DisparityConfig& config, int threads);

// A map of the left view alone, checked by the right picture.
struct PictureCheck {
    DisparityMap map;  // by refine_given(); what was unknown before is unknown
    double unlike_share =
        0;  // of the pixels that the right camera sees by the map, those of another colour there
};

// As refine_given() of a dense map, with the right view's map that the left view's implies.
PictureCheck check_by_picture(StereoPair pair, const DisparityMap& left,
                              const stages::DisparityConfig& config, int threads);

}  // namespace hexrelief::job
