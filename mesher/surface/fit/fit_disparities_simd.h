// The fit's inner loops, eight triangles or vertices side by side: each lane adds in its own order, so that
// vector registers change no bit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/common/counting_sort.h"
#include "mesher/common/thread_pool.h"
#include "mesher/common/uninitialized_vector.h"
#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/topology/rasterize_step.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

inline constexpr int kFitLanes = 8;

// Sums of up to eight triangles at once over their pixels.
class TriangleLanes {
  public:
    explicit TriangleLanes(const step::PixelView& view) : view_(view) {}
    bool full() const { return used_ == kFitLanes; }
    // runs: of the triangle's pixels; sums are written by the next weigh().
    void add(const step::PlanePatch& patch, std::span<const PixelRun> runs, step::TriangleSums& sums);
    // Writes the sums of the triangles added since the last time.
    void weigh();

  private:
    static constexpr int kMost_px = 32;  // of a lane at a time
    struct Lane {
        const PixelRun *run, *end;
        int next;  // pixel of the run
        step::TriangleSums* sums;
    };
    int fill();
    void sum_up(int pixels);

    step::PixelView view_;
    int used_ = 0;
    Lane lanes_[kFitLanes];
    double x_[kFitLanes], y_[kFitLanes], abx_[kFitLanes], aby_[kFitLanes], acx_[kFitLanes], acy_[kFitLanes],
        area_[kFitLanes], d0_[kFitLanes], d1_[kFitLanes], d2_[kFitLanes];
    double pixels_[kFitLanes];  // of those below, whole numbers
    double column_[kMost_px][kFitLanes], row_[kMost_px][kFitLanes], disparity_[kMost_px][kFitLanes],
        weight_[kMost_px][kFitLanes];
    double sums_[9][kFitLanes];
};

// Equations of vertices in blocks of eight, each as many slots as its vertex with most triangles has.
struct VertexLanes {
    std::vector<std::uint32_t> starts;  // of a block's slots
    // a slot's lanes: a corner's row without `own`; the triangle's other vertices
    RawVector<double> row_next, row_last, row_right;
    RawVector<std::int32_t> next, last;
    RawVector<double> diagonals, planes, values, relaxed;  // of the vertices, filled up to whole blocks
    RawVector<float> least, most;

    // Room for equations without terms.
    VertexLanes(const Buckets& corners, const std::vector<Triangle>& triangles, std::size_t vertices,
                ThreadPool& pool);
    std::size_t blocks() const { return starts.size() - 1; }
    // One sweep over blocks first .. end - 1: from values to relaxed.
    void relax(std::size_t first, std::size_t end);
};

}  // namespace hexrelief
