#include "cuda/surface/cut_disparity_mesh.h"

#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "cuda/surface/stopwatch.h"

namespace hexrelief::cuda {
namespace {

constexpr double kVertexShare = 1.5;  // as a share of the lattice's vertices: aloe at 427x370 needs 1.31

// Launches a kernel for each part, in the order of the CPU's cut_disparity_mesh(). Counts stay on the device;
// if the capacity is too small, the launches that follow do nothing.
void launch_parts(const Launch& launch, const SurfaceMemory& m, const SurfaceConfig& config) {
    const SurfaceState& s = m.state;
    find_pixel_surfaces(launch, s, m.pixels);
    snap_to_silhouettes(launch, s, m.snap);
    split_at_silhouettes(launch, s, m.split);
    begin_silhouettes(launch, s, m.silhouettes);
    label_triangles(launch, s, m.labels, true);
    for (int round = 0; round < config.split_rounds; ++round) {
        split_straddling(launch, s, m.split);
        label_triangles(launch, s, m.labels, false);
        open_edges(launch, s, m.labels);
        fit_silhouettes(launch, s, m.silhouettes, m.labels.words);
        label_triangles(launch, s, m.labels, false);
    }
    open_edges(launch, s, m.labels);
    join_cuts(launch, s, m.cuts);
    cut_vertices(launch, s, m.labels, m.cuts.cuts, m.fans);
    if (config.silhouette_inset_px > 0) inset_silhouettes(launch, s, inset_arrays(m.fit));
    fit_disparities(launch, s, m.fit);
}

constexpr unsigned kLeastVertices = 1024;

SurfaceSizes sizes_of(const surface::DisparityMeshInput& input, double vertex_share) {
    const HexMesh2D& mesh = *input.mesh;
    SurfaceSizes sizes{input.map->width, input.map->height, mesh.columns, mesh.rows, 0, 0};
    sizes.most_points = static_cast<unsigned>(vertex_share * sizes.vertices()) + kLeastVertices;
    sizes.most_triangles = 2 * sizes.most_points;
    return sizes;
}

// Byte offsets of the mesh's arrays, which the host reads as one block of memory behind the totals.
struct CutMeshLayout {
    static constexpr std::size_t kPoints = sizeof(SurfaceTotals);
    std::size_t disparities, triangles, bytes;

    explicit CutMeshLayout(const SurfaceSizes& sizes)
        : disparities(kPoints + sizes.most_points * sizeof(Vec2f)),
          triangles(disparities + sizes.most_points * sizeof(float)),
          bytes(triangles + sizes.most_triangles * sizeof(Triangle)) {}
};
static_assert(sizeof(SurfaceTotals) % 8 == 0);

SurfaceState take_state(Arena& arena, const SurfaceSizes& sizes) {
    const std::size_t pixels = sizes.pixels(), points = sizes.most_points, triangles = sizes.most_triangles;
    const std::size_t tiles =
        static_cast<std::size_t>(step::tile_sum_count(sizes.width)) * step::tile_sum_count(sizes.height);
    SurfaceState s{};
    s.sizes = sizes;
    s.counts = arena.take<SplitCounts>(1);
    const CutMeshLayout layout(sizes);
    char* const out = arena.take<char>(layout.bytes);
    s.totals = reinterpret_cast<SurfaceTotals*>(out);
    s.cut_mesh = {reinterpret_cast<Vec2f*>(out + CutMeshLayout::kPoints),
                  reinterpret_cast<Triangle*>(out + layout.triangles),
                  reinterpret_cast<float*>(out + layout.disparities), arena.take<std::uint32_t>(triangles)};
    s.pixels.disparity = arena.take<float>(pixels);
    s.pixels.flags = arena.take<std::uint8_t>(pixels + step::kMorePixelFlags);
    s.pixels.tile_sums = arena.take<std::uint32_t>(tiles);
    // one behind the other, for a single transfer
    s.board = reinterpret_cast<GridBoard*>(arena.take<char>(sizeof(GridBoard) + points * sizeof(Vec2f)));
    s.lattice.points = reinterpret_cast<Vec2f*>(s.board + 1);
    s.lattice.triangles = arena.take<Triangle>(triangles);
    s.lattice.neighbours = reinterpret_cast<std::int32_t(*)[3]>(arena.take<std::int32_t>(3 * triangles));
    s.lattice.changed = arena.take<std::uint8_t>(triangles);
    s.lattice.on_silhouette = arena.take<std::uint8_t>(sizes.vertices());
    s.labels.kept = arena.take<std::uint8_t>(triangles);
    s.labels.anchors = arena.take<std::uint32_t>(triangles);
    s.labels.straddling = arena.take<std::uint8_t>(triangles);
    s.labels.open = reinterpret_cast<std::uint8_t(*)[3]>(arena.take<std::uint8_t>(3 * triangles));
    s.labels.run_starts = arena.take<std::uint32_t>(triangles + 1);
    s.labels.runs = arena.take<surface::PixelRun>(run_capacity(sizes));
    return s;
}

}  // namespace

bool can_cut_meshes() {
    return can_fit_silhouettes();
}

DisparityMesh cut_disparity_mesh(const Launch& launch, Arena& arena, Staging& staging,
                                 const float* map_on_device, const surface::DisparityMeshInput& input,
                                 const SurfaceConfig& config, double& device_s) {
    Stopwatch stopwatch(launch.stream);
    for (double share = kVertexShare;; share *= 2) {  // NOLINT(cert-flp30-c): exact
        const SurfaceMemory memory = take_surface_memory(arena, input, config, map_on_device, share);
        upload_input(launch.stream, staging, input, !map_on_device, memory);
        stopwatch.begin();
        launch_parts(launch, memory, config);
        stopwatch.end();
        std::optional<DisparityMesh> mesh = download_mesh(launch.stream, staging, memory.state);
        if (!mesh) continue;
        device_s = stopwatch.seconds();
        return std::move(*mesh);
    }
}

SurfaceMemory take_surface_memory(Arena& arena, const surface::DisparityMeshInput& input,
                                  const SurfaceConfig& config, const float* map_on_device,
                                  double vertex_share) {
    const SurfaceSizes sizes = sizes_of(input, vertex_share);
    arena.reset();
    SurfaceState s = take_state(arena, sizes);
    s.pixels.map = map_on_device ? map_on_device : arena.take<float>(sizes.pixels());
    s.config = config;
    s.background_px = input.background_px;
    s.cell_px = surface::cell_area_px(input);
    s.part = surface::lattice_part(input);
    s.nearest_px = input.whole.nearest_px;
    s.farthest_px = input.whole.farthest_px > 0 ? input.whole.farthest_px : std::numeric_limits<float>::max();
    const SnapArrays snap = take_snap_arrays(sizes, arena);
    return {s,
            take_pixel_arrays(sizes, arena),
            snap,
            take_split_arrays(sizes, snap.silhouettes, arena),
            take_label_arrays(sizes, s.labels.runs, arena),
            take_cut_arrays(sizes, arena),
            take_fan_arrays(sizes, arena),
            take_silhouette_fit_arrays(sizes, arena),
            take_fit_arrays(sizes, arena)};
}

void upload_input(cudaStream_t stream, Staging& staging, const surface::DisparityMeshInput& input,
                  bool with_map, const SurfaceMemory& memory) {
    const DevicePixels& pixels = memory.state.pixels;
    if (with_map)
        staging.upload(stream, const_cast<float*>(pixels.map), input.map->values.data(),
                       input.map->values.size());
    GridBoard* const board = memory.state.board;
    staging.upload_behind_zeros(stream, &board->last_vote, sizeof(GridBoard) - offsetof(GridBoard, last_vote),
                                input.mesh->positions.data(), input.mesh->positions.size() * sizeof(Vec2f));
}

std::optional<DisparityMesh> download_mesh(cudaStream_t stream, Staging& staging, const SurfaceState& state) {
    const CutMeshLayout layout(state.sizes);
    SurfaceTotals totals{};
    const char* const all = staging.download_in_place(stream, state.totals, layout.bytes);
    if (all)
        std::memcpy(&totals, all, sizeof totals);
    else
        staging.download(stream, &totals, state.totals, 1);
    if (totals.missing_capacity > 0) return {};
    DisparityMesh mesh;
    mesh.points.resize(totals.mesh_points);
    mesh.disparities.resize(totals.mesh_points);
    mesh.triangles.resize(totals.mesh_triangles);
    mesh.has_one_fan_per_vertex = true;
    const std::size_t points = totals.mesh_points * sizeof(Vec2f),
                      disparities = totals.mesh_points * sizeof(float),
                      triangles = totals.mesh_triangles * sizeof(Triangle);
    if (all) {
        std::memcpy(mesh.points.data(), all + CutMeshLayout::kPoints, points);
        std::memcpy(mesh.disparities.data(), all + layout.disparities, disparities);
        std::memcpy(mesh.triangles.data(), all + layout.triangles, triangles);
    } else {
        staging.download_all(stream, {{mesh.points.data(), state.cut_mesh.points, points},
                                      {mesh.disparities.data(), state.cut_mesh.disparities, disparities},
                                      {mesh.triangles.data(), state.cut_mesh.triangles, triangles}});
    }
    return mesh;
}

}  // namespace hexrelief::cuda
