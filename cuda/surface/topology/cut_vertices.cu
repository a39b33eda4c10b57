#include "cuda/surface/topology/cut_vertices.h"

#include "cuda/common/grid.cuh"
#include "cuda/common/grid_scan.cuh"
#include "cuda/common/triangle_groups.cuh"
#include "mesher/surface/topology/label_triangles_step.h"
#include "mesher/surface/topology/vertex_fans_step.h"

namespace hexrelief::cuda {
namespace {

class DeviceFans {
  public:
    __device__ DeviceFans(const SurfaceState& s, const LabelArrays& labels, const CutArrays& cuts,
                          const FanArrays& a)
        : s_(s), labels_(labels), cuts_(cuts), a_(a), view_(s.view()) {}

    // Fills the mesh's points, triangles and source_triangles, and the runs of all kept triangles.
    __device__ void open(CooperativeGrid& grid) const {
        const unsigned points = s_.counts->points, triangles = s_.counts->triangles;
        clear(grid);
        HEXRELIEF_ROLLED
        for (unsigned i = grid.thread(); i < 3 * triangles; i += grid.threads()) find_fan(i);
        each_wanted_by_group(
            grid, triangles,
            [&](unsigned t) {
                const bool kept = s_.labels.kept[t] != 0, simple = is_simple(t);
                a_.runs[t] = kept && simple ? labels_.row_counts[t] : 0;
                return kept && !simple;
            },
            [&](unsigned t, bool has, const TriangleLanes& group) {
                each_run_row(
                    t, has, false, group, [&](unsigned, const surface::PixelRun&) {},
                    [&](unsigned count) { a_.runs[t] = count; });
            });
        grid.wait();
        // all three numberings at once
        const unsigned all = exclusive_scan(
            grid, points + 2 * triangles,
            [&](unsigned i) -> unsigned {
                if (i < points) return a_.fans[i];
                return i < points + triangles ? s_.labels.kept[i - points] : a_.runs[i - points - triangles];
            },
            [&](unsigned i, unsigned before) {
                if (i == points) a_.behind[0] = before;
                if (i == points + triangles) a_.behind[1] = before;
                if (i < points)
                    number_fans(i, before);
                else if (i < points + triangles)
                    a_.indices[i - points] = before;
                else
                    a_.run_indices[i - points - triangles] = before;
            });
        const unsigned fans = triangles ? a_.behind[0] : all, behind = triangles ? a_.behind[1] : all;
        for (unsigned t = grid.thread(); t < triangles; t += grid.threads()) {
            s_.labels.run_starts[t] = a_.run_indices[t] - behind;
            if (s_.labels.kept[t]) put_triangle(t, a_.indices[t] - fans);
        }
        const unsigned runs = all - behind, capacity = run_capacity(s_.sizes);
        if (grid.thread() == 0) {
            s_.labels.run_starts[triangles] = runs;
            s_.totals->mesh_points = fans;
            s_.totals->mesh_triangles = behind - fans;
            if (fans > s_.sizes.most_points) s_.totals->missing_capacity = fans - s_.sizes.most_points;
            if (runs > capacity) s_.totals->missing_capacity = runs - capacity;
        }
        if (runs <= capacity)
            each_wanted_by_group(
                grid, triangles, [&](unsigned t) { return s_.labels.kept[t] != 0; },
                [&](unsigned t, bool has, const TriangleLanes& group) {
                    surface::PixelRun* const own = s_.labels.runs + (a_.run_indices[t] - behind);
                    each_run_row(
                        t, has, is_simple(t), group,
                        [&](unsigned i, const surface::PixelRun& run) { own[i] = run; }, [](unsigned) {});
                });
        grid.wait();
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    // Clears all arrays of the mesh, because the host may also copy the unused rest.
    __device__ void clear(const CooperativeGrid& grid) const {
        for (unsigned t = grid.thread(); t < s_.sizes.most_triangles; t += grid.threads())
            s_.cut_mesh.triangles[t] = {0, 0, 0};
        grid.each(s_.sizes.most_points, [&](unsigned v) {
            a_.lists[v] = kNone;
            a_.fans[v] = 0;
            s_.cut_mesh.points[v] = {0, 0};
            s_.cut_mesh.disparities[v] = 0;
        });
    }
    // True if a triangle's runs are its rows with pixels.
    __device__ bool is_simple(unsigned t) const {
        constexpr std::uint8_t kBoth = LabelArrays::kPlain | LabelArrays::kTrusted;
        return (labels_.states[t] & kBoth) == kBoth;
    }
    // Finds the first corner of a corner's fan. Around a vertex without cuts there is a single fan.
    __device__ void find_fan(std::uint32_t corner) const {
        const std::uint32_t t = corner / 3, k = corner % 3;
        if (!s_.labels.kept[t]) return;
        const std::uint32_t v = s_.lattice.triangles[t][k];
        if (cuts_.cuts[v] == 0) {
            a_.firsts[corner] = kNone;
            a_.fans[v] = 1;
            return;
        }
        const step::FanView<const std::int32_t(*)[3], const std::uint8_t(*)[3]> view{
            s_.lattice.triangles, s_.lattice.neighbours, s_.labels.open, s_.labels.kept};
        std::uint32_t first = corner;
        step::each_of_fan(view, {t, k}, [&](const step::Corner& c) {
            first = min(first, c.number());
            return true;
        });
        a_.firsts[corner] = first;
        if (first != corner) return;
        atomicAdd(&a_.fans[v], 1);
        a_.next[corner] = atomicExch(&a_.lists[v], corner);
    }
    // Numbers the fans of a vertex by their first corners.
    __device__ void number_fans(std::uint32_t v, std::uint32_t before) const {
        if (cuts_.cuts[v] == 0) {
            a_.wholes[v] = before;
            if (a_.fans[v]) put_vertex(v, before);
            return;
        }
        for (std::uint32_t i = a_.lists[v]; i != kNone; i = a_.next[i]) {
            std::uint32_t number = before;
            for (std::uint32_t j = a_.lists[v]; j != kNone; j = a_.next[j]) number += j < i;
            a_.numbers[i] = number;
            put_vertex(v, number);
        }
    }
    __device__ void put_vertex(std::uint32_t v, std::uint32_t number) const {
        if (number >= s_.sizes.most_points) return;
        s_.cut_mesh.points[number] = s_.lattice.points[v];
    }
    __device__ void put_triangle(unsigned t, unsigned at) const {
        const Triangle v = s_.lattice.triangles[t];
        const auto number = [&](unsigned k) {
            const std::uint32_t first = a_.firsts[3 * t + k];
            return first == kNone ? a_.wholes[v[k]] : a_.numbers[first];
        };
        s_.cut_mesh.triangles[at] = {number(0), number(1), number(2)};
        s_.cut_mesh.source_triangles[at] = t;
    }
    // Calls put(i, run) for the runs of pixels that a triangle's surface is fitted to, numbered in their
    // order, each by some lane of its group; then done(count) by one lane.
    template <typename Put, typename Done>
    __device__ void each_run_row(unsigned t, bool has, bool simple, const TriangleLanes& group,
                                 const Put& put, const Done& done) const {
        const Vec2f* const p = labels_.corners[t];
        unsigned count = 0;
        each_row_by_group(
            group, {view_.width, view_.height, p[0], p[1], p[2]}, has, 0, [&](const GroupRow& row) {
                unsigned own = 0;
                if (row.own) {
                    if (simple)
                        own = 1;
                    else
                        each_fitted(t, row.run, [&](const surface::PixelRun&) { ++own; });
                }
                unsigned all = 0;
                unsigned next = count + group.sum_before(own, all);
                count += all;
                if (own == 0) return;
                if (simple)
                    put(next, row.run);
                else
                    each_fitted(t, row.run, [&](const surface::PixelRun& run) { put(next++, run); });
            });
        if (has && group.lane == 0) done(count);
    }
    // Calls visit(run) for those runs within a row.
    template <typename Visit>
    __device__ void each_fitted(unsigned t, const surface::PixelRun& row, const Visit& visit) const {
        const std::uint32_t start = static_cast<std::uint32_t>(view_.index(0, row.y)),
                            place = step::triangle_id(t, true);
        int first = row.end;  // start of the run that has not ended yet
        for (int start_x = row.first; start_x < row.end; start_x += 8) {
            bool fitted[8];  // loaded together, because each load takes long
            HEXRELIEF_UNROLL
            for (int k = 0; k < 8; ++k) {
                const std::uint32_t i = start + start_x + k;
                fitted[k] = start_x + k < row.end &&
                            (labels_.triangle_ids[i] == place) & ((view_.flags[i] & step::kTrusted) != 0);
            }
            HEXRELIEF_UNROLL
            for (int k = 0; k < 8; ++k) {
                const int x = start_x + k;
                if (fitted[k] && first == row.end) first = x;
                if (fitted[k] || first == row.end || x >= row.end) continue;
                visit(surface::PixelRun{row.y, first, x});
                first = row.end;
            }
        }
        if (first < row.end) visit(surface::PixelRun{row.y, first, row.end});
    }

    const SurfaceState& s_;
    const LabelArrays& labels_;
    const CutArrays& cuts_;
    const FanArrays& a_;
    step::PixelView view_;
};

__global__ void __launch_bounds__(kGridThreads, 1)
    split_vertices_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ LabelArrays labels,
                          const __grid_constant__ CutArrays cuts, const __grid_constant__ FanArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceFans(s, labels, cuts, a).open(grid);
}

}  // namespace

void cut_vertices(const Launch& launch, const SurfaceState& s, const LabelArrays& labels,
                  const CutArrays& cuts, const FanArrays& a) {
    launch_cooperative(launch, split_vertices_kernel, 0, "splitting vertices", s, labels, cuts, a);
}

}  // namespace hexrelief::cuda
