// Records as single accesses: member by member the compiler would make several of them.
#pragma once

#include <cuda_runtime.h>

#include <cstring>

#include "cuda/matching/refine/pixel_record.h"

namespace hexrelief::cuda {

__device__ inline PixelRecord read_record(const PixelRecord* from) {
    const uint4 words = __ldg(reinterpret_cast<const uint4*>(from));
    PixelRecord record;
    memcpy(&record, &words, sizeof record);
    return record;
}
__device__ inline void write_record(const PixelRecord& record, PixelRecord* to) {
    uint4 words;
    memcpy(&words, &record, sizeof record);
    *reinterpret_cast<uint4*>(to) = words;
}

}  // namespace hexrelief::cuda
