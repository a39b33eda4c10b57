// From both views' disparities to a map that is dense, smooth on surfaces and sharp between them.
#pragma once

#include "cuda/matching/common/stage_clock.h"
#include "cuda/matching/refine/consistency.h"
#include "cuda/matching/refine/fill.h"
#include "cuda/matching/refine/speckles.h"
#include "cuda/matching/refine/votes.h"

namespace hexrelief::cuda {

struct RefineArrays {
    RasterView<std::int16_t> left, right;  // the views' winners, to be set before
    RasterView<std::int16_t> a, b;         // maps between
    SlopeRasters fitted;
    RasterView<PixelRecord> records, other_records;
    TrustedRasters trusted;
    SpeckleArrays speckles;
    FillArrays fill;
    VoteArrays votes;
    RasterView<std::int16_t> result;  // without a border
};

RefineArrays take_refine_arrays(cudaStream_t stream, Arena& arena, const RasterView<std::int16_t>& left,
                                const RasterView<std::int16_t>& right);

// Sets result and trusted.matched.
void refine(cudaStream_t stream, const RefineArrays& arrays, const PackedColors& colors,
            const ConsistencyConfig& config, StageClock& clock);

}  // namespace hexrelief::cuda
