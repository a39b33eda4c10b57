#include "cuda/surface/topology/cut_vertices.h"

#include "cuda/common/grid.cuh"
#include "cuda/common/triangle_groups.cuh"
#include "mesher/surface/topology/label_triangles_step.h"

namespace hexrelief::cuda {
namespace {

class DeviceCutter {
  public:
    __device__ DeviceCutter(const SurfaceState& s, const LabelArrays& labels, const unsigned* cuts,
                            const FanArrays& a)
        : s_(s), labels_(labels), cuts_(cuts), a_(a), view_(s.view()) {}

    // Fills the mesh's points, triangles and source_triangles, and the runs of all kept triangles.
    __device__ void cut(CooperativeGrid& grid) const {
        const unsigned triangles = s_.counts->triangles;
        clear(grid);
        const step::FanView<const std::int32_t(*)[3], const std::uint8_t(*)[3]> view{
            s_.lattice.triangles, s_.lattice.neighbours, s_.labels.open, s_.labels.kept};
        const step::VertexCutter cutter(grid, view, s_.counts->points, triangles, cuts_, a_);
        const step::CutMeshSize size = cutter.number();
        cutter.write(s_.lattice.points, {s_.cut_mesh.points, s_.cut_mesh.triangles,
                                         s_.cut_mesh.source_triangles, s_.sizes.most_points});
        const unsigned runs = find_runs(grid, triangles), capacity = run_capacity(s_.sizes);
        if (grid.is_first()) {
            s_.labels.run_starts[triangles] = runs;
            s_.totals->mesh_points = size.points;
            s_.totals->mesh_triangles = size.triangles;
            if (size.points > s_.sizes.most_points)
                s_.totals->missing_capacity = size.points - s_.sizes.most_points;
            if (runs > capacity) s_.totals->missing_capacity = runs - capacity;
        }
        if (runs <= capacity)
            each_wanted_by_group(
                grid, triangles, [&](unsigned t) { return s_.labels.kept[t] != 0; },
                [&](unsigned t, bool has, const TriangleLanes& group) {
                    surface::PixelRun* const own = s_.labels.runs + s_.labels.run_starts[t];
                    each_run_row(
                        t, has, is_simple(t), group,
                        [&](unsigned i, const surface::PixelRun& run) { own[i] = run; }, [](unsigned) {});
                });
        grid.wait();
    }

  private:
    // Clears all arrays of the mesh, because the host may also copy the unused rest.
    __device__ void clear(const CooperativeGrid& grid) const {
        for (unsigned t = grid.thread(); t < s_.sizes.most_triangles; t += grid.threads())
            s_.cut_mesh.triangles[t] = {0, 0, 0};
        for (unsigned v = grid.thread(); v < s_.sizes.most_points; v += grid.threads()) {
            s_.cut_mesh.points[v] = {0, 0};
            s_.cut_mesh.disparities[v] = 0;
        }
    }
    // Counts and numbers the runs of all kept triangles; returns their number.
    __device__ unsigned find_runs(const CooperativeGrid& grid, unsigned triangles) const {
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
        return exclusive_scan(
            grid, triangles, [&](unsigned t) -> unsigned { return a_.runs[t]; },
            [&](unsigned t, unsigned before) { s_.labels.run_starts[t] = before; });
    }
    // True if a triangle's runs are its rows with pixels.
    __device__ bool is_simple(unsigned t) const {
        constexpr std::uint8_t kBoth = LabelArrays::kPlain | LabelArrays::kTrusted;
        return (labels_.states[t] & kBoth) == kBoth;
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
    const unsigned* cuts_;
    const FanArrays& a_;
    step::PixelView view_;
};

__global__ void __launch_bounds__(kGridThreads, 1)
    cut_vertices_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ LabelArrays labels,
                        const unsigned* cuts, const __grid_constant__ FanArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceCutter(s, labels, cuts, a).cut(grid);
}

__global__ void __launch_bounds__(kGridThreads, 1)
    join_cuts_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ step::CutArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    const step::FanView view{s.lattice.triangles, s.lattice.neighbours, s.labels.open, s.labels.kept};
    step::CutJoiner(grid, view, a).join(s.counts->points, s.counts->triangles);
}

}  // namespace

void cut_vertices(const Launch& launch, const SurfaceState& s, const LabelArrays& labels,
                  const unsigned* cuts, const FanArrays& a) {
    launch_cooperative(launch, cut_vertices_kernel, 0, "cutting vertices", s, labels, cuts, a);
}

void join_cuts(const Launch& launch, const SurfaceState& s, const step::CutArrays& a) {
    launch_cooperative(launch, join_cuts_kernel, 0, "joining cuts", s, a);
}

}  // namespace hexrelief::cuda
