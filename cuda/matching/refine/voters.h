// The weights of pixels as voters, and the blurred colours for votes in holes.
#pragma once

#include "cuda/matching/common/pixel_list.h"
#include "cuda/matching/refine/pixel_record.h"
#include "pipeline/matching/refine/side_step.h"

namespace hexrelief::cuda {

struct VoterInput {
    matching::DisparityView map;  // the filled map, or that of the round before
    matching::RasterView<const std::int32_t> nearest_seen;
    PackedColors left, right;
    int min_px;
    bool in_color;  // false: the packed colours are grey
};

// The sides of each block's discontinuities (see voter_step.h).
using BlockSides = matching::RasterView<step::Sides>;
BlockSides take_block_sides(Arena& arena, int width, int height);

// Sets `out` to the mean colours of 3x3 pixels.
void blur_colors(cudaStream_t stream, const PackedColors& colors,
                 const matching::RasterView<std::uint32_t>& out);
// Sets the weights of the first round, and `sides`. Adds to `holes`, which must be the pixels without a
// match, those whose side is not certain.
void weigh_voters(cudaStream_t stream, const VoterInput& input,
                  const matching::RasterView<const std::uint8_t>& matched, const BlockSides& sides,
                  const PixelList& holes, const matching::RasterView<std::uint8_t>& weights);
// Sets the weights of a later round in the map's records, and `sides`.
void weigh_later_voters(cudaStream_t stream, const VoterInput& input, const BlockSides& sides,
                        const matching::RasterView<PixelRecord>& records);

}  // namespace hexrelief::cuda
