#include "cuda/surface/disparity_mesh.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "cuda/surface/fit/fit_disparities.cuh"
#include "cuda/surface/fit/fit_silhouettes.cuh"
#include "cuda/surface/fit/inset_silhouettes.cuh"
#include "cuda/surface/fit/remove_slivers.cuh"
#include "cuda/surface/pixels/discontinuities.cuh"
#include "cuda/surface/pixels/speckles.cuh"
#include "cuda/surface/topology/cut_vertices.cuh"
#include "cuda/surface/topology/join_cuts.cuh"
#include "cuda/surface/topology/label_triangles.cuh"
#include "cuda/surface/topology/snap_vertices.cuh"
#include "cuda/surface/topology/split_triangles.cuh"
#include "mesher/surface/pixels/discontinuities_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 32 * kMostGridWarps;
constexpr double kRoom = 1.5;  // of the mesh, in vertices of the lattice: aloe at 427x370 takes 1.31
constexpr unsigned kLeastRoom = 1024;
constexpr unsigned kSharedBytes =
    std::max<unsigned>({kFitSharedBytes, kPieceSharedBytes, kSilhouetteSharedBytes});

// What only its own part of the kernel knows.
struct SurfaceArrays {
    PixelArrays pixels;
    AlignArrays align;
    SplitArrays split;
    LabelArrays sides;
    CutArrays cuts;
    FanArrays fans;
    SilhouetteFitArrays silhouettes;
    FitArrays fit;
    SliverArrays slivers;
};

// Inlined, so that the kernel's parameters stay where they are read fastest.
template <typename CooperativeGrid>
__device__ __forceinline__ void cut_disparity_mesh(CooperativeGrid& grid, const SurfaceState& s,
                                                   const SurfaceArrays& a) {
    const auto fits = [&] { return *static_cast<volatile unsigned*>(&s.totals->too_many) == 0; };
    begin_silhouettes(grid, s, a.silhouettes);
    find_pixel_surfaces(grid, s, a.pixels);
    snap_to_silhouettes(grid, s, a.align);
    split_at_silhouettes(grid, s, a.split);
    if (!fits()) return;
    begin_sides(grid, s, a.sides);
    // Each part is called in one place: twice its code would not fit the instruction cache.
    HEXRELIEF_ROLLED
    for (int half = 0;; ++half) {
        const bool last = half == 2 * s.settings.split_rounds, fits_next = half % 2 == 1;
        update_sides(grid, s, a.sides);
        if (fits_next || last) open_edges(grid, s, a.sides);
        if (last) break;
        if (fits_next)
            fit_silhouettes(grid, s, a.silhouettes, a.sides.words,
                            step::silhouette_least_move_px(half / 2, s.settings.split_rounds));
        else
            split_straddling(grid, s, a.split);
        if (!fits()) return;
    }
    join_cuts(grid, s, a.sides, a.cuts);
    split_non_manifold_vertices(grid, s, a.sides, a.cuts, a.fans);
    if (!fits()) return;
    if (s.settings.silhouette_inset_px > 0) inset_silhouettes(grid, s, a.silhouettes);
    fit_disparities(grid, s, a.fit);
    if (!s.settings.bridge) remove_slivers(grid, s, a.slivers);
}

__global__ void __launch_bounds__(kBlock, 1)
    surface_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ SurfaceArrays a,
                   GridBoard* board) {
    CooperativeGrid grid(blockIdx.x, gridDim.x, board);
    cut_disparity_mesh(grid, s, a);
}

SurfaceSizes sizes_of(const DisparityMeshInput& input, double room) {
    const HexMesh2D& mesh = *input.mesh;
    SurfaceSizes sizes{input.map->width, input.map->height, mesh.columns, mesh.rows, 0, 0};
    sizes.most_points = static_cast<unsigned>(room * sizes.vertices()) + kLeastRoom;
    sizes.most_triangles = 2 * sizes.most_points;
    return sizes;
}

// Where the mesh lies that the host asks for, in one piece.
struct CutMeshOutput {
    static constexpr std::size_t kPoints = sizeof(SurfaceTotals);
    std::size_t disparities, triangles, bytes;

    explicit CutMeshOutput(const SurfaceSizes& sizes)
        : disparities(kPoints + sizes.most_points * sizeof(Vec2f)),
          triangles(disparities + sizes.most_points * sizeof(float)),
          bytes(triangles + sizes.most_triangles * sizeof(Triangle)) {}
};
static_assert(sizeof(SurfaceTotals) % 8 == 0);

SurfaceState take_state(Arena& arena, const SurfaceSizes& sizes, std::size_t color_bytes) {
    const std::size_t pixels = sizes.pixels(), points = sizes.most_points, triangles = sizes.most_triangles;
    const std::size_t tiles =
        static_cast<std::size_t>(step::tile_sum_count(sizes.width)) * step::tile_sum_count(sizes.height);
    SurfaceState s{};
    s.sizes = sizes;
    const CutMeshOutput output(sizes);
    char* const out = arena.take<char>(output.bytes);
    s.totals = reinterpret_cast<SurfaceTotals*>(out);
    s.pixels.color = color_bytes > 0 ? arena.take<std::uint8_t>(color_bytes) : nullptr;
    s.pixels.disparity = arena.take<float>(pixels);
    s.pixels.flags = arena.take<std::uint8_t>(pixels);
    s.pixels.shifts = color_bytes > 0 ? arena.take<std::int8_t>(2 * pixels) : nullptr;
    s.pixels.tile_sums = arena.take<std::uint32_t>(tiles);
    char* const front = arena.take<char>(sizeof(GridBoard) + points * sizeof(Vec2f));
    s.lattice.points = reinterpret_cast<Vec2f*>(front + sizeof(GridBoard));
    s.lattice.triangles = arena.take<Triangle>(triangles);
    s.lattice.neighbours = reinterpret_cast<std::int32_t(*)[3]>(arena.take<std::int32_t>(3 * triangles));
    s.lattice.changed = arena.take<std::uint8_t>(triangles);
    s.lattice.on_silhouette = arena.take<std::uint8_t>(sizes.vertices());
    s.sides.kept = arena.take<std::uint8_t>(triangles);
    s.sides.anchors = arena.take<std::uint32_t>(triangles);
    s.sides.straddling = arena.take<std::uint8_t>(triangles);
    s.sides.open = reinterpret_cast<std::uint8_t(*)[3]>(arena.take<std::uint8_t>(3 * triangles));
    s.sides.run_starts = arena.take<std::uint32_t>(triangles + 1);
    s.sides.runs = arena.take<PixelRun>(run_room(sizes));
    s.cut_mesh = {reinterpret_cast<Vec2f*>(out + CutMeshOutput::kPoints),
                  reinterpret_cast<Triangle*>(out + output.triangles),
                  reinterpret_cast<float*>(out + output.disparities), arena.take<std::uint32_t>(points),
                  arena.take<std::uint32_t>(triangles)};
    return s;
}

SurfaceArrays take_arrays(Arena& arena, const SurfaceState& s) {
    const SurfaceSizes& sizes = s.sizes;
    const auto take = [&]<typename T>(std::size_t count) { return arena.take<T>(count); };
    const AlignArrays align = take_align_arrays(sizes, take);
    return {take_pixel_arrays(sizes, take),
            align,
            take_split_arrays(sizes, align.silhouettes, take),
            take_side_arrays(sizes, s.sides.runs, take),
            take_cut_arrays(sizes, take),
            take_fan_arrays(sizes, take),
            take_silhouette_fit_arrays(sizes, take),
            take_fit_arrays(sizes, take),
            take_sliver_arrays(sizes, take)};
}

DisparityMesh mesh_from(const char* from, const CutMeshOutput& output, const SurfaceTotals& totals) {
    const auto take = [&]<typename T>(std::vector<T>& to, std::size_t at, std::size_t count) {
        const T* const first = reinterpret_cast<const T*>(from + at);
        to.assign(first, first + count);
    };
    DisparityMesh cut_mesh;
    take(cut_mesh.points, CutMeshOutput::kPoints, totals.mesh_points);
    take(cut_mesh.disparities, output.disparities, totals.mesh_points);
    take(cut_mesh.triangles, output.triangles, totals.mesh_triangles);
    return cut_mesh;
}

void download_mesh(cudaStream_t stream, Staging& staging, const CutMesh& from, const SurfaceTotals& totals,
                   DisparityMesh& cut_mesh) {
    cut_mesh.points.resize(totals.mesh_points);
    cut_mesh.disparities.resize(totals.mesh_points);
    cut_mesh.triangles.resize(totals.mesh_triangles);
    staging.download_all(
        stream, {{cut_mesh.points.data(), from.points, totals.mesh_points * sizeof(Vec2f)},
                 {cut_mesh.disparities.data(), from.disparities, totals.mesh_points * sizeof(float)},
                 {cut_mesh.triangles.data(), from.triangles, totals.mesh_triangles * sizeof(Triangle)}});
}

// A pair of events around the kernel.
class Stopwatch {
  public:
    explicit Stopwatch(cudaStream_t stream) : stream_(stream) {
        check(cudaEventCreate(&begin_), "creating an event");
        if (const cudaError_t status = cudaEventCreate(&end_); status != cudaSuccess) {
            cudaEventDestroy(begin_);
            check(status, "creating an event");
        }
    }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;
    ~Stopwatch() {
        cudaEventDestroy(begin_);
        cudaEventDestroy(end_);
    }
    void begin() { check(cudaEventRecord(begin_, stream_), "timing"); }
    void end() { check(cudaEventRecord(end_, stream_), "timing"); }
    // After the stream has come to the end.
    double seconds() const {
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, begin_, end_), "timing");
        return milliseconds * 1e-3;
    }

  private:
    cudaStream_t stream_;
    cudaEvent_t begin_ = nullptr, end_ = nullptr;
};

}  // namespace

bool can_cut_meshes() {
    int blocks = 0;
    const bool fits = cudaFuncSetAttribute(surface_kernel, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                           kSharedBytes) == cudaSuccess &&
                      cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, surface_kernel, kBlock,
                                                                    kSharedBytes) == cudaSuccess;
    if (!fits) cudaGetLastError();  // a refusal is no failure
    return fits && blocks > 0;
}

DisparityMeshResult cut_disparity_mesh(const Launch& launch, Arena& arena, Staging& staging,
                                       const float* map_on_device, const DisparityMeshInput& input,
                                       const SurfaceConfig& config) {
    const cudaStream_t stream = launch.stream;
    const DisparityMap& map = *input.map;
    const bool colored = input.color && config.color_shift_px > 0;
    Stopwatch stopwatch(stream);
    for (double room = kRoom;; room *= 2) {
        const SurfaceSizes sizes = sizes_of(input, room);
        arena.reset();
        SurfaceState state = take_state(arena, sizes, colored ? input.color->pixels.size() : 0);
        state.pixels.map = map_on_device ? map_on_device : arena.take<float>(sizes.pixels());
        state.settings = {input.background_px,
                          static_cast<float>(config.max_disparity_discontinuity_px),
                          config.discontinuities == Discontinuities::bridge,
                          static_cast<float>(config.color_shift_px),
                          config.split_rounds,
                          config.silhouette_inset_px,
                          cell_area_px(input)};
        SurfaceArrays arrays = take_arrays(arena, state);
        GridBoard* board = reinterpret_cast<GridBoard*>(state.lattice.points) - 1;
        if (!map_on_device)
            staging.upload(stream, const_cast<float*>(state.pixels.map), map.values.data(),
                           map.values.size());
        if (colored) {
            state.pixels.channels = input.color->channels;
            staging.upload(stream, const_cast<std::uint8_t*>(state.pixels.color), input.color->pixels.data(),
                           input.color->pixels.size());
        }
        staging.upload_behind_zeros(stream, board->flags, sizeof(GridBoard) - offsetof(GridBoard, flags),
                                    input.mesh->positions.data(),
                                    input.mesh->positions.size() * sizeof(Vec2f));
        void* arguments[] = {&state, &arrays, &board};
        stopwatch.begin();
        check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(surface_kernel),
                                          dim3(launch.multiprocessors), dim3(kBlock), arguments, kSharedBytes,
                                          stream),
              "opening the sheet");
        stopwatch.end();
        SurfaceTotals totals{};
        const CutMeshOutput output(sizes);
        const char* const all = staging.download_in_place(stream, state.totals, output.bytes);
        if (all)
            std::memcpy(&totals, all, sizeof totals);
        else
            staging.download(stream, &totals, state.totals, 1);
        if (totals.too_many > 0) continue;
        DisparityMeshResult result;
        if (all)
            result.cut_mesh = mesh_from(all, output, totals);
        else
            download_mesh(stream, staging, state.cut_mesh, totals, result.cut_mesh);
        result.device_s = stopwatch.seconds();
        result.device_bytes = arena.peak_bytes() + (map_on_device ? map.values.size() * sizeof(float) : 0);
        return result;
    }
}

}  // namespace hexrelief::cuda
