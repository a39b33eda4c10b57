// Turns both views' disparities into a map that is dense, smooth on surfaces and sharp between them.
#pragma once

#include "cuda/matching/common/workspace.h"
#include "cuda/matching/refine/consistency.h"
#include "cuda/matching/refine/fill.h"
#include "cuda/matching/refine/frame_segments.h"
#include "cuda/matching/refine/remove_speckles.h"
#include "cuda/matching/refine/voters.h"
#include "cuda/matching/refine/votes.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::cuda {

inline constexpr int kUnknownBytes = 0xff;  // the byte that makes up kUnknown16, for borders

// Both views' winners and the matches of the left view; all with a border of kUnknown16. `checked` may be
// the same as `left`.
struct CheckArrays {
    matching::RasterView<std::int16_t> left, right;
    matching::RasterView<std::int16_t> left_medians, right_medians;  // uninitialised
    SpeckleArrays speckles;
    matching::RasterView<std::int16_t> checked;
};
// Filters and compares the views and removes speckles; sets `checked`.
void check_views(cudaStream_t stream, const CheckArrays& arrays, const matching::ConsistencyConfig& config);

// Trusted matches of the left view at half size, in 1/16 px above min_px.
struct DeviceHalfSizeMatches {
    matching::RasterView<std::int16_t> left;
    int min_px;
};

// All arrays of refining.
struct RefineArrays {
    // The views' winners, set by the caller. The left one becomes the filled map.
    matching::RasterView<std::int16_t> left, right;
    matching::RasterView<std::int16_t> a, b;  // intermediate maps
    SlopeArrays slopes;
    matching::RasterView<PixelRecord> records;
    matching::RasterView<PlaneRecord> planes[2];  // the first one shares the memory of records
    TrustedRasters trusted;
    SpeckleArrays speckles;
    KnownPixels known;
    FrameArrays frame;
    BlockSides sides;
    matching::RasterView<std::uint8_t> voter_weights;  // of the first round
    VoteArrays votes[step::kVoteRounds];               // one per round
    matching::RasterView<std::int16_t> result;         // without a border
};

RefineArrays take_refine_arrays(Arena& arena, const matching::RasterView<std::int16_t>& left,
                                const matching::RasterView<std::int16_t>& right, const FrameArrays& frame);

struct RefineInput {
    DeviceColors colors;
    PackedColors hole_colors;  // see blur_colors()
    DeviceHalfSizeMatches half_size;
    matching::ConsistencyConfig config;
};

// The steps, in this order. Afterwards `result` and trusted.matched are set.
void fill(Workspace& work, const RefineArrays& arrays, const RefineInput& input);
void raise_frame_segments(Workspace& work, const matching::FrameSegments& segments,
                          const RefineArrays& arrays);
void smooth(Workspace& work, const RefineArrays& arrays, const RefineInput& input);

}  // namespace hexrelief::cuda
