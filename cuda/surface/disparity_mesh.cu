#include "cuda/surface/disparity_mesh.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "cuda/surface/topology/snap_vertices.cuh"
#include "cuda/surface/topology/join_cuts.cuh"
#include "cuda/surface/topology/cut_vertices.cuh"
#include "cuda/surface/fit/fit_disparities.cuh"
#include "cuda/surface/fit/inset_silhouettes.cuh"
#include "cuda/surface/fit/remove_slivers.cuh"
#include "cuda/surface/pixels/discontinuities.cuh"
#include "cuda/surface/fit/fit_silhouettes.cuh"
#include "cuda/surface/topology/label_triangles.cuh"
#include "cuda/surface/pixels/speckles.cuh"
#include "cuda/surface/topology/split_triangles.cuh"
#include "mesher/surface/pixels/discontinuities_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 32 * kMostCrewWarps;
constexpr double kRoom = 1.5;  // of the sheet, in vertices of the lattice: aloe at 427x370 takes 1.31
constexpr unsigned kLeastRoom = 1024;
constexpr unsigned kSharedBytes = std::max<unsigned>({kFitSharedBytes, kPieceSharedBytes, kRimSharedBytes});

// What only its own part of the kernel knows.
struct SheetArrays {
    PixelArrays pixels;
    AlignArrays align;
    SplitArrays split;
    SideArrays sides;
    CutArrays cuts;
    FanArrays fans;
    RimFitArrays rims;
    FitArrays fit;
    NeedleArrays needles;
};

// Inlined, so that the kernel's parameters stay where they are read fastest.
template <typename Crew>
__device__ __forceinline__ void open_sheet(Crew& crew, const SheetState& s, const SheetArrays& a) {
    const auto fits = [&] { return *static_cast<volatile unsigned*>(&s.totals->too_many) == 0; };
    begin_rims(crew, s, a.rims);
    find_surfaces(crew, s, a.pixels);
    align_to_rims(crew, s, a.align);
    split_at_rims(crew, s, a.split);
    if (!fits()) return;
    begin_sides(crew, s, a.sides);
    // Each part is called in one place: twice its code would not fit the instruction cache.
    HEXRELIEF_ROLLED
    for (int half = 0;; ++half) {
        const bool last = half == 2 * s.settings.split_rounds, fits_next = half % 2 == 1;
        update_sides(crew, s, a.sides);
        if (fits_next || last) open_edges(crew, s, a.sides);
        if (last) break;
        if (fits_next)
            fit_rims(crew, s, a.rims, a.sides.words,
                     step::rim_least_move_px(half / 2, s.settings.split_rounds));
        else
            split_mixed(crew, s, a.split);
        if (!fits()) return;
    }
    join_cuts(crew, s, a.sides, a.cuts);
    open_fans(crew, s, a.sides, a.cuts, a.fans);
    if (!fits()) return;
    if (s.settings.rim_inset_px > 0) inset_rims(crew, s, a.rims);
    fit_disparities(crew, s, a.fit);
    if (!s.settings.bridge) drop_needles(crew, s, a.needles);
}

__global__ void __launch_bounds__(kBlock, 1)
    sheet_kernel(const __grid_constant__ SheetState s, const __grid_constant__ SheetArrays a,
                 CrewBoard* board) {
    Crew crew(blockIdx.x, gridDim.x, board);
    open_sheet(crew, s, a);
}

SheetSizes sizes_of(const SheetInput& input, double room) {
    const HexMesh2D& mesh = *input.mesh;
    SheetSizes sizes{input.map->width, input.map->height, mesh.columns, mesh.rows, 0, 0};
    sizes.most_points = static_cast<unsigned>(room * sizes.vertices()) + kLeastRoom;
    sizes.most_triangles = 2 * sizes.most_points;
    return sizes;
}

// Where the sheet lies that the host asks for, in one piece.
struct SheetOutput {
    static constexpr std::size_t kPoints = sizeof(SheetTotals);
    std::size_t disparities, triangles, bytes;

    explicit SheetOutput(const SheetSizes& sizes)
        : disparities(kPoints + sizes.most_points * sizeof(Vec2f)),
          triangles(disparities + sizes.most_points * sizeof(float)),
          bytes(triangles + sizes.most_triangles * sizeof(Triangle)) {}
};
static_assert(sizeof(SheetTotals) % 8 == 0);

SheetState take_state(Arena& arena, const SheetSizes& sizes, std::size_t color_bytes) {
    const std::size_t pixels = sizes.pixels(), points = sizes.most_points, triangles = sizes.most_triangles;
    const std::size_t tiles =
        static_cast<std::size_t>(step::tile_sum_count(sizes.width)) * step::tile_sum_count(sizes.height);
    SheetState s{};
    s.sizes = sizes;
    const SheetOutput output(sizes);
    char* const out = arena.take<char>(output.bytes);
    s.totals = reinterpret_cast<SheetTotals*>(out);
    s.pixels.color = color_bytes > 0 ? arena.take<std::uint8_t>(color_bytes) : nullptr;
    s.pixels.disparity = arena.take<float>(pixels);
    s.pixels.flags = arena.take<std::uint8_t>(pixels);
    s.pixels.shifts = color_bytes > 0 ? arena.take<std::int8_t>(2 * pixels) : nullptr;
    s.pixels.tile_sums = arena.take<std::uint32_t>(tiles);
    char* const front = arena.take<char>(sizeof(CrewBoard) + points * sizeof(Vec2f));
    s.lattice.points = reinterpret_cast<Vec2f*>(front + sizeof(CrewBoard));
    s.lattice.triangles = arena.take<Triangle>(triangles);
    s.lattice.neighbours = reinterpret_cast<std::int32_t(*)[3]>(arena.take<std::int32_t>(3 * triangles));
    s.lattice.changed = arena.take<std::uint8_t>(triangles);
    s.lattice.on_rim = arena.take<std::uint8_t>(sizes.vertices());
    s.sides.kept = arena.take<std::uint8_t>(triangles);
    s.sides.anchors = arena.take<std::uint32_t>(triangles);
    s.sides.mixed = arena.take<std::uint8_t>(triangles);
    s.sides.open = reinterpret_cast<std::uint8_t(*)[3]>(arena.take<std::uint8_t>(3 * triangles));
    s.sides.run_starts = arena.take<std::uint32_t>(triangles + 1);
    s.sides.runs = arena.take<PixelRun>(run_room(sizes));
    s.sheet = {reinterpret_cast<Vec2f*>(out + SheetOutput::kPoints),
               reinterpret_cast<Triangle*>(out + output.triangles),
               reinterpret_cast<float*>(out + output.disparities), arena.take<std::uint32_t>(points),
               arena.take<std::uint32_t>(triangles)};
    return s;
}

SheetArrays take_arrays(Arena& arena, const SheetState& s) {
    const SheetSizes& sizes = s.sizes;
    const auto take = [&]<typename T>(std::size_t count) { return arena.take<T>(count); };
    const AlignArrays align = take_align_arrays(sizes, take);
    return {take_pixel_arrays(sizes, take),
            align,
            take_split_arrays(sizes, align.rims, take),
            take_side_arrays(sizes, s.sides.runs, take),
            take_cut_arrays(sizes, take),
            take_fan_arrays(sizes, take),
            take_rim_fit_arrays(sizes, take),
            take_fit_arrays(sizes, take),
            take_needle_arrays(sizes, take)};
}

SheetMesh sheet_from(const char* from, const SheetOutput& output, const SheetTotals& totals) {
    const auto take = [&]<typename T>(std::vector<T>& to, std::size_t at, std::size_t count) {
        const T* const first = reinterpret_cast<const T*>(from + at);
        to.assign(first, first + count);
    };
    SheetMesh sheet;
    take(sheet.points, SheetOutput::kPoints, totals.sheet_points);
    take(sheet.disparities, output.disparities, totals.sheet_points);
    take(sheet.triangles, output.triangles, totals.sheet_triangles);
    return sheet;
}

void download_sheet(cudaStream_t stream, Staging& staging, const SheetParts& from, const SheetTotals& totals,
                    SheetMesh& sheet) {
    sheet.points.resize(totals.sheet_points);
    sheet.disparities.resize(totals.sheet_points);
    sheet.triangles.resize(totals.sheet_triangles);
    staging.download_all(
        stream, {{sheet.points.data(), from.points, totals.sheet_points * sizeof(Vec2f)},
                 {sheet.disparities.data(), from.disparities, totals.sheet_points * sizeof(float)},
                 {sheet.triangles.data(), from.triangles, totals.sheet_triangles * sizeof(Triangle)}});
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

bool can_open_sheets() {
    int blocks = 0;
    const bool fits = cudaFuncSetAttribute(sheet_kernel, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                           kSharedBytes) == cudaSuccess &&
                      cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, sheet_kernel, kBlock,
                                                                    kSharedBytes) == cudaSuccess;
    if (!fits) cudaGetLastError();  // a refusal is no failure
    return fits && blocks > 0;
}

SheetResult open_sheet(const Launch& launch, Arena& arena, Staging& staging, const float* map_on_device,
                       const SheetInput& input, const SheetConfig& config) {
    const cudaStream_t stream = launch.stream;
    const DisparityMap& map = *input.map;
    const bool colored = input.color && config.color_shift_px > 0;
    Stopwatch stopwatch(stream);
    for (double room = kRoom;; room *= 2) {
        const SheetSizes sizes = sizes_of(input, room);
        arena.reset();
        SheetState state = take_state(arena, sizes, colored ? input.color->pixels.size() : 0);
        state.pixels.map = map_on_device ? map_on_device : arena.take<float>(sizes.pixels());
        state.settings = {input.background_px,
                          static_cast<float>(config.max_disparity_jump_px),
                          config.discontinuities == Discontinuities::bridge,
                          static_cast<float>(config.color_shift_px),
                          config.split_rounds,
                          config.rim_inset_px,
                          cell_area_px(input)};
        SheetArrays arrays = take_arrays(arena, state);
        CrewBoard* board = reinterpret_cast<CrewBoard*>(state.lattice.points) - 1;
        if (!map_on_device)
            staging.upload(stream, const_cast<float*>(state.pixels.map), map.values.data(),
                           map.values.size());
        if (colored) {
            state.pixels.channels = input.color->channels;
            staging.upload(stream, const_cast<std::uint8_t*>(state.pixels.color), input.color->pixels.data(),
                           input.color->pixels.size());
        }
        staging.upload_behind_zeros(stream, board->flags, sizeof(CrewBoard) - offsetof(CrewBoard, flags),
                                    input.mesh->positions.data(),
                                    input.mesh->positions.size() * sizeof(Vec2f));
        void* arguments[] = {&state, &arrays, &board};
        stopwatch.begin();
        check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(sheet_kernel),
                                          dim3(launch.multiprocessors), dim3(kBlock), arguments, kSharedBytes,
                                          stream),
              "opening the sheet");
        stopwatch.end();
        SheetTotals totals{};
        const SheetOutput output(sizes);
        const char* const all = staging.look_at(stream, state.totals, output.bytes);
        if (all)
            std::memcpy(&totals, all, sizeof totals);
        else
            staging.download(stream, &totals, state.totals, 1);
        if (totals.too_many > 0) continue;
        SheetResult result;
        if (all)
            result.sheet = sheet_from(all, output, totals);
        else
            download_sheet(stream, staging, state.sheet, totals, result.sheet);
        result.device_s = stopwatch.seconds();
        result.device_bytes = arena.peak_bytes() + (map_on_device ? map.values.size() * sizeof(float) : 0);
        return result;
    }
}

}  // namespace hexrelief::cuda
