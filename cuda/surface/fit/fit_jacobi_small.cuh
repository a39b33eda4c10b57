// The sweeps of the fit's linear solver if vertices are few: without barriers between them.
#pragma once

#include "cuda/common/grid.cuh"
#include "cuda/common/relaxed.cuh"
#include "cuda/surface/fit/fit_disparities.h"

namespace hexrelief::cuda {

// A few lanes handle a vertex through all sweeps, with a corner or two each; a vertex waits only for its
// neighbours. Two arrays of values are enough: before a value is overwritten, all neighbours of its
// vertex have read it.
class FitFlow {
  public:
    // Returns the number of lanes per vertex; 0 if there are too many vertices.
    __device__ static unsigned lanes(const CooperativeGrid& grid, unsigned points) {
        return 8 * points <= grid.threads() ? 8 : 4 * points <= grid.threads() ? 4 : 0;
    }
    // Loads the data that are known before the triangles' sums, so that they are there after the barrier.
    __device__ FitFlow(const CooperativeGrid& grid, const SurfaceState& s, const FitArrays& a,
                       unsigned points, unsigned size)
        : s_(s),
          a_(a),
          size_(size),
          lane_(grid.lane() % size),
          vertex_(32 / size * grid.warp() + grid.lane() / size),
          has_(vertex_ < points),
          is_idle_(32 / size * grid.warp() >= points) {
        if (is_idle_) return;
        const unsigned v = has_ ? vertex_ : 0;
        start_ = a.starts[v];
        count_ = has_ ? a.counts[v] : 0;
        plane_ = a.planes[v];
        floor_ = step::lowest_disparity(s.totals->farthest_px);
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kSlots; ++k) corners_[k].place(s, a, start_, count_, k * size_ + lane_);
    }
    // Clears a vertex's values; to be called before the constructor, with a barrier in between.
    __device__ static void clear(const FitArrays& a, unsigned v) {
        store_relaxed(a.flow[0] + v, {0, 0});
        store_relaxed(a.flow[1] + v, {0, 0});
    }
    // Computes the mesh's disparities from a.values.
    __device__ void run() {
        if (is_idle_) return;
        double value = a_.values[has_ ? vertex_ : 0], diagonal = step::kFitPlaneWeight;
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kSlots; ++k) {
            const double own = corners_[k].weigh(a_);
            if (k == 0 || __any_sync(~0u, count_ > k * size_)) add(own, diagonal);
        }
        each_other([&](Corner& corner) { add(corner.weigh(a_), diagonal); });
        HEXRELIEF_ROLLED
        for (unsigned sweep = 0; sweep < step::kFitSweeps; ++sweep) {
            double sum = step::kFitPlaneWeight * plane_, terms[kSlots];
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < kSlots; ++k) terms[k] = 0;
            wait_for(sweep, terms);
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < kSlots; ++k)
                if (k == 0 || __any_sync(~0u, count_ > k * size_)) add(terms[k], sum);
            each_other([&](Corner& corner) {
                corner.weigh(a_);
                double term = 0;
                while (!__all_sync(~0u, corner.see(a_, sweep, term))) {
                }
                add(term, sum);
            });
            value = step::relaxed(value, sum, diagonal, floor_);
            if (lane_ != 0 || !has_) continue;
            if (sweep + 1 < step::kFitSweeps)
                store_relaxed(a_.flow[sweep % 2] + vertex_, {value, sweep + 1});
            else
                s_.cut_mesh.disparities[vertex_] = static_cast<float>(value);
        }
    }

  private:
    static constexpr unsigned kSlots = 2;

    // One of the triangles at the vertex.
    struct Corner {
        bool is_one = false;
        unsigned triangle = 0, k = 0, next = 0, last = 0;  // next, last: its other vertices
        double next_row = 0, last_row = 0, right = 0;

        __device__ void place(const SurfaceState& s, const FitArrays& a, unsigned start, unsigned count,
                              unsigned number) {
            is_one = number < count;
            if (!is_one) return;
            const unsigned item = a.items[start + number];
            triangle = item / 3;
            k = item % 3;
            const Triangle t = s.cut_mesh.triangles[triangle];
            next = k == 0 ? t[1] : k == 1 ? t[2] : t[0];
            last = k == 0 ? t[2] : k == 1 ? t[0] : t[1];
        }
        // Sets the corner's terms and returns its part of the diagonal.
        __device__ double weigh(const FitArrays& a) {
            if (!is_one) return 0;
            const step::CornerRow row = step::corner_row(a.triangles[triangle].sums, k);
            next_row = row.next;
            last_row = row.last;
            right = row.right;
            return row.own;
        }
        // Gives the corner's part of the right-hand side; returns false if it is not known yet.
        __device__ bool see(const FitArrays& a, unsigned sweep, double& term) const {
            if (!is_one) return true;
            double nexts, lasts;
            bool known = true;
            if (sweep == 0) {
                nexts = a.values[next];
                lasts = a.values[last];
            } else {
                const FitValue* const from = a.flow[(sweep - 1) % 2];
                const FitValue of_next = load_relaxed(from + next), of_last = load_relaxed(from + last);
                known = of_next.sweeps == sweep && of_last.sweeps == sweep;
                nexts = of_next.value;
                lasts = of_last.value;
            }
            if (known) term = step::right_side({0, next_row, last_row, right}, nexts, lasts);
            return known;
        }
    };

    __device__ void wait_for(unsigned sweep, double (&terms)[kSlots]) const {
        bool known;
        do {
            known = true;
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < kSlots; ++k) known &= corners_[k].see(a_, sweep, terms[k]);
        } while (!__all_sync(~0u, known));
    }
    // Adds the lanes' terms in order.
    __device__ void add(double term, double& sum) const {
        HEXRELIEF_UNROLL
        for (unsigned i = 0; i < 8; i += 4) {
            if (i >= size_) break;
            HEXRELIEF_UNROLL
            for (unsigned j = i; j < i + 4; ++j)
                sum += __shfl_sync(~0u, term, static_cast<int>(j), static_cast<int>(size_));
        }
    }
    // Calls visit(corner) for the corners beyond the slots.
    template <typename Visit>
    __device__ void each_other(const Visit& visit) const {
        HEXRELIEF_ROLLED
        for (unsigned first = kSlots * size_; __any_sync(~0u, first < count_); first += size_) {
            Corner corner;
            corner.place(s_, a_, start_, count_, first + lane_);
            visit(corner);
        }
    }

    const SurfaceState& s_;
    const FitArrays& a_;
    const unsigned size_, lane_, vertex_;
    const bool has_, is_idle_;
    unsigned start_ = 0, count_ = 0;
    double plane_ = 0, floor_ = 0;
    Corner corners_[kSlots];
};

}  // namespace hexrelief::cuda
