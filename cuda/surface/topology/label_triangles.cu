#include "cuda/surface/topology/label_triangles.h"

#include "cuda/common/flag_words.cuh"
#include "cuda/common/grid.cuh"
#include "cuda/common/triangle_groups.cuh"
#include "cuda/surface/topology/triangle_components.cuh"
#include "cuda/surface/topology/triangle_lists.cuh"
#include "mesher/surface/topology/label_triangles_step.h"
#include "mesher/surface/topology/split_lattice_step.h"

namespace hexrelief::cuda {
namespace {

class DeviceLabels {
  public:
    __device__ DeviceLabels(const SurfaceState& s, const LabelArrays& a)
        : s_(s), a_(a), view_(s.view()), words_(a.words, view_) {}

    __device__ void update(const CooperativeGrid& grid, bool first) const {
        if (first) begin(grid);
        const unsigned count = s_.counts->triangles, known = s_.counts->known;
        each_wanted_by_group(
            grid, known, [&](unsigned t) { return s_.lattice.changed[t] != step::kSame; },
            [&](unsigned t, bool has, const TriangleLanes& group) {
                bool is_large = false;
                const bool leaves = leave(t, has, group, is_large);
                list(0).put(a_.counts->changed, t, leaves, is_large);
            });
        if (grid.thread() == 0) {
            a_.counts->voting = {0, 0};
            for (unsigned& taken : a_.counts->taken) taken = 0;
        }
        grid.wait();
        const LabelArrays::Listed listed = a_.counts->changed;
        const unsigned changed = listed.all(), fresh = changed + count - known;
        // If they are few, a group also finds its triangle's components right away.
        const bool at_once = fresh <= grid.threads() / 16;
        LabelArrays::Listed left{fresh - listed.many, listed.many};
        HEXRELIEF_ROLLED
        for (bool finding = true;; finding = false) {
            each_by_group(grid, left.many, left.few, kLeastGroup / 2, a_.counts->taken + finding,
                          [&](unsigned i, bool has, const TriangleLanes& group) {
                              const bool is_new = finding && i >= changed;
                              const unsigned t = !has     ? 0
                                                 : is_new ? known + (i - changed)
                                                          : list(finding ? 0 : 1).at(left, i);
                              const Triangle v = s_.lattice.triangles[t];
                              const Corners corners{s_.lattice.points[v[0]], s_.lattice.points[v[1]],
                                                    s_.lattice.points[v[2]]};
                              const surface::TriangleRows rows = rows_of(corners);
                              unsigned segments = 0;
                              if (finding)
                                  segments = find_pixels(t, has, is_new, corners, rows, group);
                              else if (has)
                                  segments = a_.row_counts[t];
                              if (finding && !at_once) {
                                  list(1).put(a_.counts->several, t, segments > 0 && group.lane == 0,
                                              is_tall(rows));
                                  segments = 0;
                              }
                              if (__any_sync(kAllLanes, segments > 0)) choose_label(t, segments, rows, group);
                          });
            grid.wait();
            if (at_once || !finding) break;
            left = a_.counts->several;
        }
        if (grid.thread() == 0) {
            s_.counts->known = count;
            const unsigned capacity = run_capacity(s_.sizes);
            if (a_.counts->pool_used > capacity)
                s_.totals->missing_capacity = a_.counts->pool_used - capacity;
            a_.counts->changed = a_.counts->several = {0, 0};
            a_.counts->pool_used = 0;
        }
    }

  private:
    __device__ void begin(const CooperativeGrid& grid) const {
        const unsigned pixels = s_.sizes.pixels();
        HEXRELIEF_ROLLED
        for (unsigned i = grid.thread(); i < pixels; i += grid.threads()) a_.triangle_ids[i] = 0;
        words_.fill(grid);
        if (grid.thread() == 0) *a_.counts = {};
        grid.wait();
    }
    static constexpr unsigned kAtOnce = 4;  // pixels, because loads take long

    struct Corners {
        Vec2f p, q, r;
    };
    __device__ TriangleList list(unsigned which) const { return {a_.lists[which], s_.sizes.most_triangles}; }
    __device__ surface::TriangleRows rows_of(const Corners& c) const {
        return {view_.width, view_.height, c.p, c.q, c.r};
    }
    // True if a triangle has more rows than the smallest group has lanes.
    __device__ static bool is_tall(const surface::TriangleRows& rows) {
        return rows.end() - rows.first() > static_cast<int>(kLeastGroup);
    }
    // Removes a triangle from the pixels that it loses. Most triangles at silhouettes move by so little that
    // they keep all their pixels, and with them all results: for these it clears `changed`. Returns true in
    // the first lane of the others.
    __device__ bool leave(unsigned t, bool has, const TriangleLanes& group, bool& is_large) const {
        const Vec2f* const old = a_.corners[t];
        const Triangle v = s_.lattice.triangles[t];
        const surface::TriangleRows was = rows_of({old[0], old[1], old[2]}),
                                    is = rows_of({s_.lattice.points[v[0]], s_.lattice.points[v[1]],
                                                  s_.lattice.points[v[2]]});
        is_large = is_tall(is);
        bool same = s_.lattice.changed[t] == step::kMoved && (a_.states[t] & LabelArrays::kAny) &&
                    was.first() == is.first() && was.end() == is.end();
        HEXRELIEF_ROLLED
        for (int y = was.first() + static_cast<int>(group.lane); has && y < was.end();
             y += static_cast<int>(group.size)) {
            const surface::PixelRun old_run = was.run(y);
            const surface::PixelRun run =
                y >= is.first() && y < is.end() ? is.run(y) : surface::PixelRun{y, 0, 0};
            same &= old_run == run;
            std::uint32_t* const triangle_ids = a_.triangle_ids + view_.index(0, y);
            // the pixels before the new run, and those after it
            const bool apart = run.first >= run.end;
            const int second = apart ? old_run.end : max(old_run.first, run.end),
                      before = max(0, (apart ? old_run.end : min(old_run.end, run.first)) - old_run.first),
                      count = before + max(0, old_run.end - second);
            HEXRELIEF_ROLLED
            for (int start = 0; start < count; start += kAtOnce) {
                std::uint32_t* at[kAtOnce];
                std::uint32_t ids[kAtOnce];
                HEXRELIEF_UNROLL
                for (unsigned k = 0; k < kAtOnce; ++k) {
                    const int i = start + static_cast<int>(k);
                    at[k] = triangle_ids + (i < before ? old_run.first + i : second + (i - before));
                    ids[k] = i < count ? *at[k] : 0;
                }
                HEXRELIEF_UNROLL
                for (unsigned k = 0; k < kAtOnce; ++k)
                    if (step::belongs(ids[k], t)) *at[k] = 0;
            }
        }
        same = group.ballot(!same) == 0;
        if (has && same && group.lane == 0) s_.lattice.changed[t] = step::kSame;
        return has && !same && group.lane == 0;
    }
    // Finds the triangle's pixels, and its label unless they may have several components. Returns the number
    // of segments of its rows in that case, else 0.
    __device__ unsigned find_pixels(unsigned t, bool has, bool is_new, const Corners& c,
                                    const surface::TriangleRows& rows, const TriangleLanes& group) const {
        unsigned row_count = 0, segments = 0;
        std::uint32_t first = 0;
        bool apart = false;  // true if rows have no column in common
        // Discontinuities at any pixel; between its pixels; pixels of speckles.
        bool any = false, inner = false, untrusted = false;
        each_row_by_group(group, rows, has, 0, [&](const GroupRow& row) {
            const surface::PixelRun& run = row.run;
            const std::uint32_t start = static_cast<std::uint32_t>(view_.index(0, run.y)),
                                begin = group.from(start + run.first,
                                                   row.all ? __ffs(static_cast<int>(row.all)) - 1 : 0);
            if (row_count == 0) first = begin;
            row_count += __popc(row.all);
            if (!row.own) return;
            ++segments;
            const bool touches = row.has_upper && step::lie_above(row.upper, run);
            apart |= row.has_upper && !touches;
            HEXRELIEF_ROLLED
            for (int x = run.first; x < run.end; x += 32) {
                const FlagWords::Bits own = words_.from(x, run.y),
                                      upper = words_.from(x, touches ? run.y - 1 : run.y);
                const unsigned within = bits_between(0, run.end - x),
                               right = own.right & bits_between(0, run.end - 1 - x);
                any |= ((own.right | own.down) & within) != 0;
                untrusted |= (~own.trusted & within) != 0;
                segments += __popc(right);
                inner |= right != 0;
                if (touches)
                    inner |=
                        (upper.down & within & bits_between(row.upper.first - x, row.upper.end - x)) != 0;
            }
            HEXRELIEF_ROLLED
            for (int x = run.first; x < run.end; ++x)
                atomicMax(&a_.triangle_ids[start + x], step::triangle_id(t, true));
        });
        const bool parted = group.ballot(apart || any) != 0, trusted = group.ballot(untrusted) == 0,
                   whole = group.ballot(apart || inner) == 0 || row_count == 0;
        segments = group.sum(segments);
        if (has && group.lane < 3) {
            a_.corners[t][group.lane] = group.lane == 0 ? c.p : group.lane == 1 ? c.q : c.r;
            if (is_new) s_.labels.open[t][group.lane] = 0;
        }
        if (has && group.lane == 0) {
            a_.states[t] = (parted ? 0 : LabelArrays::kPlain) | (trusted ? LabelArrays::kTrusted : 0) |
                           (row_count > 0 ? LabelArrays::kAny : 0);
            a_.row_counts[t] = whole ? row_count : segments;
            a_.marks[t] = static_cast<std::uint8_t>(s_.counts->votes + 1);
            s_.lattice.changed[t] = step::kSame;
            if (whole) put_label(t, row_count > 0 ? first : step::middle_pixel(view_, c.p, c.q, c.r), false);
        }
        __syncwarp();
        return has && !whole ? segments : 0;
    }
    __device__ void put_label(unsigned t, std::uint32_t anchor, bool straddling) const {
        s_.labels.straddling[t] = straddling;
        s_.labels.anchors[t] = anchor;
        s_.labels.kept[t] = view_.disparity[anchor] > 0;
    }

    // Returns memory for `segments` segments, or null if it is used up because many triangles overlap.
    __device__ ComponentArrays arrays_for(unsigned segments, const TriangleLanes& group) const {
        const bool large = segments > kSegmentsPerLane * group.size;
        if (!__any_sync(kAllLanes, large)) return shared_components(group);
        unsigned at = large && group.lane == 0 ? atomicAdd(&a_.counts->pool_used, segments) : 0;
        at = group.from(at, 0);
        if (!large) return shared_components(group);
        if (at + segments > run_capacity(s_.sizes)) return {};
        return {a_.pool.segments + at, a_.pool.areas + at};
    }
    // Labels a triangle of several components.
    __device__ void choose_label(unsigned t, unsigned segments, const surface::TriangleRows& rows,
                                 const TriangleLanes& group) const {
        const ComponentArrays arrays = arrays_for(segments, group);
        const bool has = segments > 0 && arrays.segments;
        GroupComponents components(view_, words_, group, arrays);
        components.find(rows, has);
        const bool straddling = is_straddling(t, has && components.outliers() > 0, components, group);
        if (has && group.lane == 0) put_label(t, components.first_pixel(), straddling);
        __syncwarp();
    }
    // True if the pixels of other components cost so much that the triangle should be split. Marks these
    // pixels as off the triangle's label.
    __device__ bool is_straddling(unsigned t, bool has, const GroupComponents& components,
                                  const TriangleLanes& group) const {
        if (!__any_sync(kAllLanes, has)) return false;
        double sum = 0, error = 0;
        if (has)
            components.each([&](const RowSegment& s, bool is_largest) {
                if (is_largest) sum += sum_of(s);
            });
        const double mean = group.sum(sum) / components.area(), nearest = s_.totals->nearest_px;
        if (has)
            components.each([&](const RowSegment& s, bool is_largest) {
                if (is_largest) return;
                HEXRELIEF_ROLLED
                for (std::uint32_t first = s.first; first < s.end; first += kAtOnce) {
                    float d[kAtOnce];
                    bool counts[kAtOnce];
                    HEXRELIEF_UNROLL
                    for (unsigned k = 0; k < kAtOnce; ++k) {
                        const bool there = first + k < s.end;
                        counts[k] = there && (view_.flags[first + k] & step::kTrusted);
                        d[k] = there ? view_.disparity[first + k] : 0;
                        if (there)  // other triangles may be writing their ids at the same time
                            atomicCAS(&a_.triangle_ids[first + k], step::triangle_id(t, true),
                                      step::triangle_id(t, false));
                    }
                    HEXRELIEF_UNROLL
                    for (unsigned k = 0; k < kAtOnce; ++k)
                        if (counts[k]) error += step::outlier_error(d[k], mean, nearest);
                }
            });
        error = group.sum(error);
        if (!has || components.outliers() < step::kStraddling_px || group.lane != 0) return false;
        // The order of sums changes mean and error by less than 1e-8 of their values, and a change of the
        // mean changes each pixel's error by at most 80 times as much, or by 1e-6 in holes. Only if that
        // might matter is the sum repeated in the CPU's order.
        const double limit = step::kStraddlingError_px2 * s_.cell_px,
                     slack = 1e-6 * (limit + components.outliers() * (mean + 1));
        if (error > limit + slack || error < limit - slack) return error > limit;
        return ordered_error(components, nearest) > limit;
    }
    __device__ double sum_of(const RowSegment& s) const {
        double sum = 0;
        HEXRELIEF_ROLLED
        for (std::uint32_t i = s.first; i < s.end; i += kAtOnce) {
            float d[kAtOnce];
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < kAtOnce; ++k) d[k] = i + k < s.end ? view_.disparity[i + k] : 0.0f;
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < kAtOnce; ++k) sum += d[k];
        }
        return sum;
    }
    // Returns the error added up in the CPU's order, by one lane.
    __device__ double ordered_error(const GroupComponents& components, double nearest) const {
        double sum = 0, error = 0;
        components.each_in_order([&](const RowSegment& s, bool is_largest) {
            HEXRELIEF_ROLLED
            for (std::uint32_t i = s.first; is_largest && i < s.end; ++i) sum += view_.disparity[i];
        });
        const double mean = sum / components.area();
        components.each_in_order([&](const RowSegment& s, bool is_largest) {
            HEXRELIEF_ROLLED
            for (std::uint32_t i = s.first; !is_largest && i < s.end; ++i)
                if (view_.flags[i] & step::kTrusted)
                    error += step::outlier_error(view_.disparity[i], mean, nearest);
        });
        return error;
    }

    const SurfaceState& s_;
    const LabelArrays& a_;
    step::PixelView view_;
    FlagWords words_;
};

__global__ void __launch_bounds__(kGridThreads, 1)
    label_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ LabelArrays a, bool first) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceLabels(s, a).update(grid, first);
}

}  // namespace

void label_triangles(const Launch& launch, const SurfaceState& s, const LabelArrays& a, bool first) {
    launch_cooperative(launch, label_kernel, kComponentSharedBytes, "labelling triangles", s, a, first);
}

}  // namespace hexrelief::cuda
