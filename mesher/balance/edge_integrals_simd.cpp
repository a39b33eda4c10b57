#include "mesher/balance/edge_integrals_simd.h"

#include "pipeline/base/simd.h"

namespace hexrelief::balance {
namespace {

constexpr int kLanes = 16;
constexpr int kEdges = kLanes / step::kEdgeParts;  // number of short edges that fill the lanes

// Each lane holds a part of an edge, the pixel that it has reached, and its sums.
struct SimdBatch {
    float x[kLanes], dx[kLanes], along[kLanes], across[kLanes], rise[kLanes], per_along[kLanes],
        per_across[kLanes];
    int sideways[kLanes], first[kLanes], sign[kLanes], ahead[kLanes], count[kLanes], pixel[kLanes];
    float t0[kLanes], crossing[kLanes], t1[kLanes];
    int column[kLanes], other_column[kLanes], row[kLanes], other_row[kLanes];
    double left[kLanes], right[kLanes], other_left[kLanes], other_right[kLanes];
    double columns[kLanes];
    float within[kLanes], mass[kLanes], moment[kLanes];

    step::EdgeWalk walk(int lane) const {
        return {x[lane],          dx[lane],       along[lane], across[lane], rise[lane], per_along[lane],
                per_across[lane], sideways[lane], first[lane], sign[lane],   ahead[lane]};
    }
    step::EdgeSums sums(int lane) const { return {columns[lane], within[lane], mass[lane], moment[lane]}; }
    // Loads kParts parts of an edge, from `part` on, into lanes `lane` and following.
    template <int kParts>
    void put(const step::Edge& e, int lane, int part) {
        const step::EdgeWalk w = step::edge_walk(e);
        const int pixels = step::edge_pixels(e);
        for (int i = 0; i < kParts; ++i) {
            const int k = lane + i;
            x[k] = w.x, dx[k] = w.dx, along[k] = w.along, across[k] = w.across, rise[k] = w.rise_across;
            per_along[k] = w.per_along, per_across[k] = w.per_across, sideways[k] = w.sideways;
            first[k] = w.first, sign[k] = w.sign, ahead[k] = w.ahead, count[k] = pixels;
            pixel[k] = part + i;
            columns[k] = 0, within[k] = mass[k] = moment[k] = 0;
        }
    }
};

// Adds `rounds` pixels to each lane, `stride` apart. The loops have no branches, and the reads of the
// primitive stand in a loop of their own, so that the other two loops vectorise.
HEXRELIEF_VECTORS void add_pixels(const step::BalanceView& view, int stride, int rounds,
                                  SimdBatch& __restrict l) {
    const step::BalanceView v = view;
    for (int round = 0; round < rounds; ++round) {
#pragma GCC ivdep
        for (int lane = 0; lane < kLanes; ++lane) {
            const step::PixelCut cut = step::pixel_cut(v, l.walk(lane), l.pixel[lane], l.count[lane]);
            l.t0[lane] = cut.t0, l.crossing[lane] = cut.crossing, l.t1[lane] = cut.t1;
            l.column[lane] = cut.column, l.other_column[lane] = cut.other_column;
            l.row[lane] = cut.row, l.other_row[lane] = cut.other_row;
        }
        for (int lane = 0; lane < kLanes; ++lane) {
            const double *const here = v.primitive + step::primitive_index(v, l.column[lane], l.row[lane]),
                                *const there = v.primitive + step::primitive_index(v, l.other_column[lane],
                                                                                   l.other_row[lane]);
            l.left[lane] = here[0], l.right[lane] = here[1];
            l.other_left[lane] = there[0], l.other_right[lane] = there[1];
        }
#pragma GCC ivdep
        for (int lane = 0; lane < kLanes; ++lane) {
            const step::EdgeWalk w = l.walk(lane);
            step::EdgeSums s = l.sums(lane);
            step::add_segment(w, {l.column[lane], l.left[lane], l.right[lane], l.t0[lane], l.crossing[lane]},
                              s);
            step::add_segment(
                w,
                {l.other_column[lane], l.other_left[lane], l.other_right[lane], l.crossing[lane], l.t1[lane]},
                s);
            const bool inside = l.pixel[lane] < l.count[lane];
            l.columns[lane] = inside ? s.columns : l.columns[lane];
            l.within[lane] = inside ? s.within : l.within[lane];
            l.mass[lane] = inside ? s.mass : l.mass[lane];
            l.moment[lane] = inside ? s.moment : l.moment[lane];
            l.pixel[lane] += stride;
        }
    }
}

// Number of rounds in which `parts` parts walk through all pixels of an edge.
int rounds_of(int pixels, int parts) {
    return (pixels + parts - 1) / parts;
}

// Collects the short edges of a row until they fill a batch; sums up long edges at once.
class RowEdges {
  public:
    explicit RowEdges(const step::BalanceView& view) : view_(view) {}

    void add(const step::Edge& e, int slot) {
        const int pixels = step::edge_pixels(e);
        if (pixels > step::kLongEdge_px) {
            view_.edges[slot] = step::mass_of(view_, e, sum_long(e, pixels));
            return;
        }
        short_.put<step::kEdgeParts>(e, size_ * step::kEdgeParts, 0);
        edges_[size_] = e;
        slots_[size_++] = slot;
        longest_ = longest_ < pixels ? pixels : longest_;
        if (size_ == kEdges) flush();
    }
    void flush() {
        if (size_ == 0) return;
        for (int k = size_; k < kEdges; ++k) short_.put<step::kEdgeParts>(edges_[0], k * step::kEdgeParts, 0);
        add_pixels(view_, step::kEdgeParts, rounds_of(longest_, step::kEdgeParts), short_);
        for (int k = 0; k < size_; ++k) {
            const int at = k * step::kEdgeParts;
            view_.edges[slots_[k]] =
                step::mass_of(view_, edges_[k],
                              step::sum_of_parts(short_.sums(at), short_.sums(at + 1), short_.sums(at + 2),
                                                 short_.sums(at + 3)));
        }
        size_ = longest_ = 0;
    }

  private:
    step::EdgeSums sum_long(const step::Edge& e, int pixels) {
        step::EdgeSums sums[step::kLongEdgeParts];
        for (int part = 0; part < step::kLongEdgeParts; part += kLanes) {
            long_.put<kLanes>(e, 0, part);
            add_pixels(view_, step::kLongEdgeParts, rounds_of(pixels, step::kLongEdgeParts), long_);
            for (int lane = 0; lane < kLanes; ++lane) sums[part + lane] = long_.sums(lane);
        }
        return step::sum_of_long_parts(sums);
    }

    const step::BalanceView& view_;
    SimdBatch short_, long_;
    step::Edge edges_[kEdges];
    int slots_[kEdges], size_ = 0, longest_ = 0;
};

}  // namespace

void measure_boundary_edges(const step::BalanceView& v, int row) {
    RowEdges edges(v);
    int first = 0;
    while (step::honeycomb_class(first, row) != 1) ++first;
    // edges of the same direction follow each other, as they have similar lengths
    for (int j = 0; j < 3; ++j)
        for (int column = first; column < v.lattice.columns; column += 3) {
            const step::Neighbour to = step::neighbour_of(v, column, row, 2 * j);
            const int from = row * v.lattice.columns + column,
                      slot = 3 * step::boundary_slot(v, column, row) + j;
            if (to.exists)
                edges.add(step::edge_between(v.x[from], v.y[from], v.x[to.index], v.y[to.index]), slot);
            else
                v.edges[slot] = {0, 0, 0};
        }
    edges.flush();
}

}  // namespace hexrelief::balance
