// The working size: that at which a pair is matched and meshed.
#pragma once

#include <string>

#include "pipeline/data/disparity_map.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/stages/density.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// Returns the least whole number that divides a pair's longest side into at most working_px; 1 if working_px
// is 0.
int reduction_to(int working_px, int longest_px);
// Returns that number for pictures of these sides, or less, so that at least 16 px of each side remain.
int reduction_of(const Image& picture, int working_px);

// Returns that number, doubled as long as the picture so reduced is soft and keeps a longer side of at least
// 900 px when halved; 1 if working_px is 0. Soft is a picture that hardly loses anything by halving: a lens
// out of focus, a scanned print, a picture that was enlarged. A finer mesh of it follows noise.
int reduction_of_soft(const Image& picture, int working_px, int threads);

// Returns the error of a pair whose sizes differ, with the views' names; empty if they are the same.
std::string sizes_differ(const StereoPair& pair, const std::string& left_name, const std::string& right_name);

// Cuts both pictures of a pair, of which one was cropped, to their common width and height, around their
// middles. Returns which were cut, as a warning; empty if one is shorter by more than a fifth along a side,
// and nothing was cut. Their sizes differ.
std::string cut_to_one_size(StereoPair& pair);

struct ReducedPair {
    StereoPair views;
    StereoPair pictures;  // the pair that the views are the reduction of
};
// Reduces a pair by reduction_of(). Up to by - 1 columns at the right and rows at the bottom are cut off, so
// that all of it is exactly reduced.
ReducedPair reduced(StereoPair pair, int by, int threads);

// Returns the mask for the pair so reduced; it keeps the pixels that are kept whole. Empty stays empty.
readers::PixelMask reduced(const readers::PixelMask& mask, int by);

// Return the configuration for a pair reduced by this number: what is set in px of the full pair is
// converted into px of the reduced one.
stages::DisparityConfig for_reduced(stages::DisparityConfig config, int by);
stages::DensityConfig for_reduced(stages::DensityConfig config, int by);

}  // namespace hexrelief::job
