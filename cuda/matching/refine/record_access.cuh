// Records as single accesses: member by member the compiler would make several of them.
#pragma once

#include <cuda_runtime.h>

#include <cstring>

#include "cuda/matching/refine/pixel_record.h"

namespace hexrelief::cuda {

template <typename Record>
__device__ Record read_record(const Record* from) {
    const uint4 words = __ldg(reinterpret_cast<const uint4*>(from));
    Record record;
    memcpy(&record, &words, sizeof record);
    return record;
}
template <typename Record>
__device__ void write_record(const Record& record, Record* to) {
    uint4 words;
    memcpy(&words, &record, sizeof record);
    *reinterpret_cast<uint4*>(to) = words;
}

__device__ inline std::uint32_t packed_slopes(int x, int y) {
    return __byte_perm(static_cast<unsigned>(x), static_cast<unsigned>(y), 0x5410);
}
__device__ inline int slope_x(const PixelRecord& record) {
    return static_cast<std::int16_t>(record.slopes & 0xffffu);
}
__device__ inline int slope_y(const PixelRecord& record) {
    return static_cast<std::int16_t>(record.slopes >> 16);
}
// A pixel (dx, dy) px away, as dot products take it. |dx|, |dy| < 128.
__device__ inline int packed_steps(int dx, int dy) {
    return (dx & 0xff) | (dy & 0xff) << 8;
}
// step::plane_change() to there, and `more`.
__device__ inline int plane_change(std::uint32_t slopes, int steps, int more = 0) {
    return __dp2a_lo(static_cast<int>(slopes), steps, more);
}

}  // namespace hexrelief::cuda
