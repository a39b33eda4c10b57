// The crack edges around silhouette edges, which a warp keeps from round to round.
#pragma once

#include "cuda/common/flag_words.cuh"
#include "cuda/common/grid.cuh"
#include "cuda/common/warp_reduce.cuh"
#include "mesher/surface/fit/fit_silhouettes_step.h"

namespace hexrelief::cuda {

// A warp's shared memory. All warps together need less than the 99 KB that most devices have per block.
struct SilhouetteScratch {
    static constexpr unsigned kSamples = 376;  // four vertices of cones at 1800x1500 have up to 362
    static constexpr unsigned kTerms = 92;     // at a time
    static constexpr unsigned kDiscontinuities = 3 * kTerms * sizeof(double) / sizeof(unsigned);
    union {
        // Terms of the samples with a weight: weight * across, the weight for the vertex, and that
        // weight times the residual.
        double terms[3][kTerms];
        // Listed crack edges: bits 27 .. 31 hold the lane of the pixel's row, bits 1 .. 26 its x; bit 0 is
        // set for the lower crack edge.
        unsigned discontinuities[kDiscontinuities];
        unsigned words[32];
    };
    float x[kSamples], y[kSamples];
    // Bits 0 .. 4: the mesh edge; 5: the crack edge is horizontal; 6: near_x or near_y is 1, not -1.
    std::uint8_t kinds[kSamples];
};

inline constexpr unsigned kSilhouetteSharedBytes = kGridWarps * sizeof(SilhouetteScratch);

// The part of an edge's end in its vertex's equation: the sums of weights and of weighted residuals.
struct SilhouetteSeen {
    float nx = 0, ny = 0;  // the edge's unit normal
    double weight = 0, residual = 0;
};

// The samples of up to 32 edges: lane e holds the e-th edge. All lanes of a warp call each function.
class SilhouetteSamples {
  public:
    __device__ SilhouetteSamples(const step::PixelView& view, uint4* words, SilhouetteScratch& scratch)
        : view_(view), words_(words, view), scratch_(scratch), lane_(threadIdx.x % 32) {}

    // Finds all samples within reach of each edge, with a margin for the moves of its vertices until the next
    // search. Returns false if the capacity is too small.
    __device__ bool find(unsigned edges, const Vec2f& a, const Vec2f& b) {
        from_a_ = a;
        from_b_ = b;
        const step::PixelBox box = step::pixels_around(view_, a, b, kAround_px);
        const unsigned rows = lane_ < edges ? box.y1 - box.y0 + 1 : 0;
        const unsigned rows_before = sum_before(rows), all_rows = __shfl_sync(~0u, rows_before + rows, 31);
        unsigned own_samples = 0;
        count_ = 0;
        HEXRELIEF_ROLLED
        for (unsigned base = 0; base < all_rows; base += 32) {
            const Row row = row_at(base + lane_, base + lane_ < all_rows, rows_before, edges, a, b);
            const unsigned found = list_discontinuities(row);
            if (found > SilhouetteScratch::kDiscontinuities) return false;
            HEXRELIEF_ROLLED
            for (unsigned first = 0; first < found; first += 32)
                keep_near(row, first, found, a, b, own_samples);
            if (count_ > SilhouetteScratch::kSamples) return false;
            __syncwarp();
        }
        first_ = sum_before(own_samples);
        end_ = first_ + own_samples;
        return true;
    }
    // True if an edge has left the position for which its samples were found.
    __device__ bool have_left(unsigned edges, const Vec2f& a, const Vec2f& b) const {
        return __any_sync(~0u, lane_ < edges && (has_left(from_a_, a) || has_left(from_b_, b)));
    }
    // Sums up the samples of the edges in `actives` (bits). second: true if the sums are for the edge's
    // second vertex. Returns false if the capacity is too small.
    __device__ bool see(unsigned actives, unsigned edges, const Vec2f& a, const Vec2f& b, bool second,
                        SilhouetteSeen& seen) const {
        const unsigned seconds = __ballot_sync(~0u, second);
        const step::SilhouetteEdgeFrame frame = step::silhouette_edge_frame(a, b);
        const unsigned proper = actives & __ballot_sync(~0u, frame.size2 > 0);
        if (actives >> lane_ & 1u) seen = {frame.nx, frame.ny, 0, 0};
        HEXRELIEF_ROLLED
        for (unsigned edge = 0; edge < edges;) {  // as many as fit at a time
            const unsigned start = __shfl_sync(~0u, first_, edge);
            const unsigned fit = __ballot_sync(
                ~0u, lane_ >= edge && lane_ < edges && end_ - start <= SilhouetteScratch::kTerms);
            // an edge with more samples may still fit if not all of them have a weight
            const unsigned next = fit ? 32 - __clz(fit) : edge + 1;
            const unsigned wanted = lanes_before(next, edge) << edge & proper;
            if (wanted &&
                !sum_up({edge, next, wanted, seconds}, frame, start, __shfl_sync(~0u, end_, next - 1), seen))
                return false;
            edge = next;
        }
        return true;
    }

  private:
    static constexpr float kAround_px = step::kSilhouetteFitReach_px + step::kSilhouetteStay_px;
    // A bound on the distance of a sample from the upper left corner of its pixel.
    static constexpr float kShift_px = 1.5f;

    // The pixels of a row that may have samples within reach of an edge.
    struct Row {
        unsigned edge;
        int y, x0, x1;  // x1: the last one, included
    };

    __device__ static unsigned sum_before(unsigned own) { return sum_up_to_lane(own) - own; }
    __device__ static Vec2f shuffle(const Vec2f& p, unsigned from) {
        return {__shfl_sync(~0u, p.x, from), __shfl_sync(~0u, p.y, from)};
    }
    __device__ Row row_at(unsigned item, bool is_one, unsigned rows_before, unsigned edges, const Vec2f& a,
                          const Vec2f& b) const {
        unsigned edge = 0;  // the last edge whose rows begin at `item` or before
#pragma unroll
        for (unsigned step = 16; step > 0; step /= 2) {
            const unsigned before = __shfl_sync(~0u, rows_before, edge + step & 31u);
            if (edge + step < edges && before <= item) edge += step;
        }
        const Vec2f p = shuffle(a, edge), q = shuffle(b, edge);
        const step::PixelBox box = step::pixels_around(view_, p, q, kAround_px);
        const int y = box.y0 + static_cast<int>(item - __shfl_sync(~0u, rows_before, edge));
        if (!is_one) return {0, 0, 1, 0};
        Row row{edge, y, box.x0, box.x1};
        const float dx = q.x - p.x, dy = q.y - p.y, rise = std::fabs(dy), run = std::fabs(dx);
        if (rise > 1) {  // not the whole width of a long edge's box
            const float x = p.x + (static_cast<float>(y) + 0.75f - p.y) * (dx / dy);
            const float around = (kAround_px * (run + rise) + (kShift_px + 1) * run) / rise + (kShift_px + 1);
            row.x0 = max(static_cast<int>(x - around), box.x0);
            row.x1 = min(static_cast<int>(x + around) + 1, box.x1);
        }
        return row;
    }
    // Discontinuities to the right and downwards of up to 32 pixels from x on, a bit each.
    struct Discontinuities {
        unsigned right, down;
    };
    __device__ Discontinuities discontinuities_of(const Row& row, int x) const {
        const unsigned mask = bits_between(0, row.x1 + 1 - x);
        if (mask == 0) return {0, 0};
        const FlagWords::Bits bits = words_.from(x, row.y);
        return {bits.right & mask, bits.down & mask};
    }
    // Lists the discontinuities of the lanes' rows if the capacity is large enough; returns their number.
    __device__ unsigned list_discontinuities(const Row& row) const {
        Discontinuities discontinuities = discontinuities_of(row, row.x0);
        unsigned own = __popc(discontinuities.right) + __popc(discontinuities.down);
        HEXRELIEF_ROLLED
        for (int x = row.x0 + 32; x <= row.x1; x += 32) {
            const Discontinuities more = discontinuities_of(row, x);
            own += __popc(more.right) + __popc(more.down);
        }
        unsigned place = sum_before(own);
        const unsigned all = __shfl_sync(~0u, place + own, 31);
        if (all > SilhouetteScratch::kDiscontinuities) return all;
        HEXRELIEF_ROLLED
        for (int x = row.x0; own > 0;) {
            const unsigned any = discontinuities.right | discontinuities.down;
            if (any == 0) {
                x += 32;
                discontinuities = discontinuities_of(row, x);
                continue;
            }
            // of a pixel, right before down
            const unsigned one = any & (0u - any), down = discontinuities.right & one ? 0 : 1;
            discontinuities.right &= down ? ~0u : ~one;
            discontinuities.down &= down ? ~one : ~0u;
            --own;
            scratch_.discontinuities[place++] =
                lane_ << 27 | static_cast<unsigned>(x + __ffs(one) - 1) << 1 | down;
        }
        __syncwarp();
        return all;
    }
    // Keeps the listed discontinuities from `first` on, one per lane, that are near their edges.
    __device__ void keep_near(const Row& row, unsigned first, unsigned found, const Vec2f& a, const Vec2f& b,
                              unsigned& own_samples) {
        const unsigned discontinuity = first + lane_ < found ? scratch_.discontinuities[first + lane_] : 0;
        const unsigned edge = __shfl_sync(~0u, row.edge, discontinuity >> 27);
        const int y = __shfl_sync(~0u, row.y, discontinuity >> 27);
        const Vec2f p = shuffle(a, edge), q = shuffle(b, edge);
        step::SilhouetteSample sample{};
        bool near = false;
        if (first + lane_ < found) {
            sample = step::silhouette_sample(view_, {static_cast<int>(discontinuity >> 1 & 0x3ffffffu), y,
                                                     static_cast<int>(discontinuity & 1u)});
            const float dx = q.x - p.x, dy = q.y - p.y;
            const float off = (sample.y - p.y) * dx - (sample.x - p.x) * dy;
            constexpr float kMost_px = kAround_px + step::kRounding_px;
            near = off * off <= kMost_px * kMost_px * (dx * dx + dy * dy);
        }
        const unsigned nears = __ballot_sync(~0u, near);
        const unsigned at = count_ + count_before_lane(nears);
        count_ += __popc(nears);
        if (near && at < SilhouetteScratch::kSamples) {
            scratch_.x[at] = sample.x;
            scratch_.y[at] = sample.y;
            scratch_.kinds[at] = static_cast<std::uint8_t>(edge | (sample.near_x != 0 ? 0u : 32u) |
                                                           (sample.near_x + sample.near_y > 0 ? 64u : 0u));
        }
        // count them by edge: those of an edge follow each other
        HEXRELIEF_ROLLED
        for (unsigned left = nears; left;) {
            const unsigned one = __shfl_sync(~0u, edge, __ffs(left) - 1);
            const unsigned same = __ballot_sync(~0u, edge == one) & nears;
            if (lane_ == one) own_samples += __popc(same);
            left &= ~same;
        }
    }
    __device__ static bool has_left(const Vec2f& from, const Vec2f& p) {
        const float dx = p.x - from.x, dy = p.y - from.y;
        return dx * dx + dy * dy > step::kSilhouetteStay_px * step::kSilhouetteStay_px;
    }
    // Returns the lanes of 32 items from `base` on that come before the item.
    __device__ static unsigned lanes_before(unsigned item, unsigned base) {
        return item <= base ? 0 : item >= base + 32 ? ~0u : (1u << (item - base)) - 1;
    }
    // Edges whose samples are summed up together: those of lanes first .. end - 1; wanted, seconds: bits of
    // those wanted and of those whose second vertex the sums are for.
    struct Batch {
        unsigned first, end, wanted, seconds;
    };
    // Sums up the samples start .. end - 1 of a batch. Returns false if those with a
    // weight exceed the capacity.
    __device__ bool sum_up(const Batch& batch, const step::SilhouetteEdgeFrame& frame, unsigned start,
                           unsigned end, SilhouetteSeen& seen) const {
        unsigned own_first = 0;
        const unsigned count = write_terms(batch, frame, start, end, own_first);
        if (count > SilhouetteScratch::kTerms) return false;
        __syncwarp();
        unsigned own_end = __shfl_down_sync(~0u, own_first, 1);
        if (lane_ + 1 >= batch.end) own_end = count;
        add_terms(batch, own_first, own_end, seen);
        return true;
    }
    // Writes the terms of the samples with a weight, up to the capacity; returns their number. own_first:
    // index of the first term of the lane's edge.
    __device__ unsigned write_terms(const Batch& batch, const step::SilhouetteEdgeFrame& frame,
                                    unsigned start, unsigned end, unsigned& own_first) const {
        unsigned count = 0;
        HEXRELIEF_ROLLED
        for (unsigned base = start; base < end; base += 32) {
            const unsigned i = base + lane_;
            const unsigned kind = i < end ? scratch_.kinds[i] : 0, e = kind & 31u;
            const bool is_wanted = i < end && (batch.wanted >> e & 1u);
            if (!__any_sync(~0u, is_wanted)) continue;
            const step::SilhouetteEdgeFrame f{__shfl_sync(~0u, frame.x, e),     __shfl_sync(~0u, frame.y, e),
                                              __shfl_sync(~0u, frame.dx, e),    __shfl_sync(~0u, frame.dy, e),
                                              __shfl_sync(~0u, frame.size2, e), __shfl_sync(~0u, frame.nx, e),
                                              __shfl_sync(~0u, frame.ny, e)};
            step::SilhouetteResidual own{};
            if (is_wanted) {
                const float towards = kind & 64u ? 1.0f : -1.0f;
                own = step::silhouette_residual(f, {scratch_.x[i], scratch_.y[i], kind & 32u ? 0.0f : towards,
                                                    kind & 32u ? towards : 0.0f});
            }
            const unsigned counting = __ballot_sync(~0u, own.weight != 0);
            const unsigned at = count + count_before_lane(counting);
            if (own.weight != 0 && at < SilhouetteScratch::kTerms) {
                const double weight =
                    static_cast<double>(own.weight) * (batch.seconds >> e & 1u ? own.share : 1 - own.share);
                scratch_.terms[0][at] = own.weight * own.across;
                scratch_.terms[1][at] = weight;
                scratch_.terms[2][at] = weight * own.residual;
            }
            count += __popc(counting);
            own_first += __popc(counting & lanes_before(first_, base));
        }
        return count;
    }
    // Adds up the terms. own_first, own_end: the terms of the lane's edge.
    __device__ void add_terms(const Batch& batch, unsigned own_first, unsigned own_end,
                              SilhouetteSeen& seen) const {
        // Five lanes per edge add one sum each: weight * across of all samples, then weights and residuals of
        // the samples that face left, then those of the samples that face right.
        constexpr unsigned kSums = 5, kEdges = 32 / kSums;
        const unsigned sum_of = lane_ % kSums;
        const double* const terms = scratch_.terms[sum_of == 0 ? 0 : 2 - sum_of % 2];
        HEXRELIEF_ROLLED
        for (unsigned edge = batch.first; edge < batch.end; edge += kEdges) {
            const unsigned e = edge + lane_ / kSums;
            unsigned i = __shfl_sync(~0u, own_first, e & 31u), last = __shfl_sync(~0u, own_end, e & 31u);
            if (lane_ >= kSums * kEdges || e >= batch.end || !(batch.wanted >> e & 1u)) last = i;
            double sum = 0;
            HEXRELIEF_ROLLED
            for (; i < last; i += 4) {
                double more[4];  // 0 for terms that do not belong to the lane's sum
#pragma unroll
                for (unsigned k = 0; k < 4; ++k) {
                    const bool is_one = i + k < last;
                    const bool left = is_one && __double2hiint(scratch_.terms[0][i + k]) > 0;
                    more[k] = is_one && (sum_of == 0 || left == (sum_of < 3)) ? terms[i + k] : 0.0;
                }
#pragma unroll
                for (unsigned k = 0; k < 4; ++k) sum += more[k];
            }
            __syncwarp();
            const unsigned first_lane = (lane_ - edge) * kSums;
            const double facing = __shfl_sync(~0u, sum, first_lane & 31u);
            const unsigned faced = first_lane + (facing > 0 ? 1 : 3);
            const double weight = __shfl_sync(~0u, sum, faced & 31u),
                         residual = __shfl_sync(~0u, sum, faced + 1 & 31u);
            if (lane_ >= edge && lane_ < min(batch.end, edge + kEdges) && (batch.wanted >> lane_ & 1u)) {
                seen.weight = facing != 0 ? weight : 0;
                seen.residual = facing != 0 ? residual : 0;
            }
        }
        __syncwarp();
    }

    const step::PixelView view_;
    const FlagWords words_;
    SilhouetteScratch& scratch_;
    const unsigned lane_;
    unsigned count_ = 0;
    unsigned first_ = 0, end_ = 0;  // samples of the own edge
    Vec2f from_a_{}, from_b_{};     // its position when they were found
};

}  // namespace hexrelief::cuda
