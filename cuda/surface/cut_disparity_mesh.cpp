#include "cuda/surface/cut_disparity_mesh.h"

#include <optional>
#include <utility>

#include "cuda/surface/fit/inset_silhouettes.h"
#include "cuda/surface/stopwatch.h"
#include "cuda/surface/surface_memory.h"
#include "cuda/surface/topology/edge_votes.h"

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

}  // namespace hexrelief::cuda
