// The pixels of one triangle, dealt out to the lanes of a warp in their order.
#pragma once

#include <cstdint>

#include "cuda/warp_reduce.cuh"
#include "mesher/steps/rim.h"
#include "mesher/steps/triangle_pixels.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::cuda {

inline constexpr unsigned kAllLanes = 0xffffffffu;

// A pixel of a lane. k: which of the triangle's it is. row: the lane that holds its row, which goes from
// first to end. Nothing but k and row counts unless valid.
struct LanePixel {
    bool valid;
    unsigned k, row;
    int x, y, first, end;
    std::uint32_t index;
};

// Rows of a triangle, one a lane: the first and the last lane have those around the others', or none.
struct LaneRows {
    PixelRun run{};       // of the lane
    bool own = false;     // whether it has pixels, and is no lane at an end
    unsigned before = 0;  // pixels of the triangle before it
    PixelRun upper{};     // the last row with pixels above
    unsigned upper_before = 0;
    bool has_upper = false;
    unsigned first = 0, end = 0;  // pixels of all own rows, by k
};

class TriangleWarp {
  public:
    __device__ TriangleWarp(const step::PixelView& view, const Vec2f& a, const Vec2f& b, const Vec2f& c)
        : rows_(view.width, view.height, a, b, c), width_(view.width), lane_(threadIdx.x % 32) {
        chunks_ = (rows_.end() - rows_.first() + kOwn - 1) / kOwn;
        if (chunks_ == 1) load(0, {});
    }
    // Calls visit(rows) for a warp's share of rows after the other, by all lanes.
    template <typename Visit>
    __device__ void each_rows(const Visit& visit) {
        LaneRows last;
        for (int chunk = 0; chunk < chunks_; ++chunk) {
            if (chunks_ > 1) {
                load(chunk, last);
                last = rows_now_;
            }
            visit(rows_now_);
        }
    }
    // Calls visit(pixel) for 32 pixels of the rows after the other, by all lanes.
    template <typename Visit>
    __device__ void each_pixel(const LaneRows& rows, const Visit& visit) const {
        for (unsigned k = rows.first + lane_; k - lane_ < rows.end; k += 32) {
            unsigned row = 0;  // the last whose pixels begin at k or before
            for (unsigned step = 16; step > 0; step /= 2)
                if (__shfl_sync(kAllLanes, rows.before, row + step) <= k) row += step;
            LanePixel pixel{};
            pixel.valid = k < rows.end;
            pixel.k = k;
            pixel.row = row;
            pixel.first = __shfl_sync(kAllLanes, rows.run.first, row);
            pixel.end = __shfl_sync(kAllLanes, rows.run.end, row);
            pixel.y = __shfl_sync(kAllLanes, rows.run.y, row);
            pixel.x = pixel.first + static_cast<int>(k - __shfl_sync(kAllLanes, rows.before, row));
            pixel.index = static_cast<std::uint32_t>(pixel.y) * width_ + pixel.x;
            visit(pixel);
        }
    }
    template <typename Visit>
    __device__ void each_pixel(const Visit& visit) {
        each_rows([&](const LaneRows& rows) { each_pixel(rows, visit); });
    }

  private:
    static constexpr int kOwn = 30;

    __device__ void load(int chunk, const LaneRows& last) {
        const int y = rows_.first() + chunk * kOwn + static_cast<int>(lane_) - 1;
        LaneRows now;
        now.run = {y, 0, 0};
        if (y >= rows_.first() && y < rows_.end()) now.run = rows_.run(y);
        const bool inner = lane_ > 0 && lane_ <= kOwn;
        const unsigned count = inner ? static_cast<unsigned>(now.run.end - now.run.first) : 0;
        now.own = count > 0;
        unsigned sum = count;
        for (unsigned step = 1; step < 32; step *= 2) {
            const unsigned other = __shfl_up_sync(kAllLanes, sum, step);
            if (lane_ >= step) sum += other;
        }
        now.first = last.end;
        now.end = last.end + __shfl_sync(kAllLanes, sum, 31);
        now.before = last.end + sum - count;
        // the last lane with pixels above; of the rows before, what that lane or its own last one knew
        const unsigned with_pixels = __ballot_sync(kAllLanes, now.own),
                       above = with_pixels & ((1u << lane_) - 1);
        const unsigned source = above ? 31 - __clz(above) : 0;
        now.upper = {__shfl_sync(kAllLanes, now.run.y, source), __shfl_sync(kAllLanes, now.run.first, source),
                     __shfl_sync(kAllLanes, now.run.end, source)};
        now.upper_before = __shfl_sync(kAllLanes, now.before, source);
        now.has_upper = above != 0;
        // lane 31 has no row of its own, so what lies above it is the last row of the chunk
        const PixelRun carried{__shfl_sync(kAllLanes, last.upper.y, 31),
                               __shfl_sync(kAllLanes, last.upper.first, 31),
                               __shfl_sync(kAllLanes, last.upper.end, 31)};
        const unsigned carried_before = __shfl_sync(kAllLanes, last.upper_before, 31);
        const bool carries = __shfl_sync(kAllLanes, static_cast<int>(last.has_upper), 31) != 0;
        if (!above && carries) {
            now.upper = carried;
            now.upper_before = carried_before;
            now.has_upper = true;
        }
        rows_now_ = now;
    }

    TriangleRows rows_;
    int width_;
    unsigned lane_;
    int chunks_;
    LaneRows rows_now_;
};

}  // namespace hexrelief::cuda
