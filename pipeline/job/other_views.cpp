#include "pipeline/job/other_views.h"

#include <algorithm>
#include <span>
#include <utility>

#include "exporters/images/resize.h"
#include "pipeline/data/error.h"
#include "pipeline/dequantize/dequantize.h"
#include "pipeline/dequantize/noise.h"
#include "pipeline/job/matchers/given_maps.h"
#include "pipeline/stages/other_views/behind_silhouettes.h"

namespace hexrelief::job {
namespace {

using stages::OtherView;
using stages::ViewPlace;

constexpr int kReduced = 2;               // what continues behind the left view's silhouettes is smooth
constexpr double kCoarser = 1.5;          // spacing of the other views: what has no match has little detail
constexpr double kFarther = 63. / 64;     // share of the least disparity
constexpr double kMostBackground = 0.01;  // share of a view that is dropped and hardly opens it
constexpr double kFittingSpacings = 3;    // of solve_mesh()

ViewPlace left_place(const LeftView& view) {
    return {0, 0, 0, 1, view.disparity.width, view.disparity.height};
}

// Returns the surface as the cameras see it. What is added may be a little farther than all of it, so that it
// is not level with the farthest.
stages::VisibleSurface seen_by_cameras(const SurfaceMesh& mesh, const LeftView& view, int threads) {
    std::vector<ViewPlace> cameras = {left_place(view)};
    if (view.right) cameras.push_back(view.right->place);
    const double least_px = *std::min_element(mesh.disparities.begin(), mesh.disparities.end());
    return stages::visible_surface(mesh, cameras, kFarther * least_px, threads);
}

// True if a part of the view that matters is background: then the scene is open between its things, and such
// gaps are not behind a silhouette.
bool is_without_background(const LeftView& view) {
    const std::vector<float>& values = view.disparity.values;
    const auto dropped = std::count_if(values.begin(), values.end(), [&](float d) {
        return DisparityMap::known(d) && d < view.density.background_px;
    });
    return static_cast<double>(dropped) > kMostBackground * static_cast<double>(values.size());
}

// The left view with nothing missing yet. Its texture is smaller, as what continues is smooth.
OtherView copy_of_left(const LeftView& view) {
    OtherView left{left_place(view), {}, {}, view.color};
    const int width = view.color.width / kReduced, height = view.color.height / kReduced;
    if (std::min(width, height) > 0) left.picture = exporters::resized(view.color, width, height);
    return left;
}

void show(OtherView& view, const stages::SeenSurface& here) {
    view.missing = {view.place.width, view.place.height, {}};
    view.missing.values.assign(here.disparities.size(), kUnknownDisparity);
    view.map = view.missing;
    for (std::size_t i = 0; i < here.disparities.size(); ++i)
        if (here.disparities[i] != stages::kNotCovered)
            view.map.values[i] = static_cast<float>(here.disparities[i]);
}

// Returns the missing part as a surface in the left camera's space; empty if there is nothing large enough.
SurfaceMesh sheet_of(const OtherView& other, const DensityMap& density, const LeftView& left,
                     const stages::VisibleSurface& visible, const config::Config& config, Backend& backend,
                     const RunLog& log) {
    const Calibration camera = stages::camera_at(other.place, left.calibration);
    const LeftView view{
        other.missing,   other.missing, density, other.color,
        other.texture(), camera,        camera,  left.least_px / static_cast<float>(other.place.scale)};
    if (std::min(other.map.width, other.map.height) < kFittingSpacings * kCoarser * config.mesh.spacing_px)
        return {};
    backend.expect_map(other.missing);
    MeshConfig coarse = config.mesh;
    coarse.spacing_px *= kCoarser;
    const HexMesh2D lattice = backend.solve_mesh(density, coarse, {});
    DisparityMesh cut = cut_lattice(lattice, view, config.surface, backend, log);
    stages::keep_behind(cut, other.place, visible);
    if (cut.triangles.empty()) return {};
    try {
        return stages::in_left_space(surface_of(cut, view, config.surface), other.place, left.calibration);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        return {};  // all components are too small
    }
}

DensityMap density_of_view(const DisparityMap& map, stages::DensityConfig config, int threads) {
    config.background_method = stages::BackgroundMethod::none;
    return stages::compute_density(map, config, threads);
}

// Returns the view whose map, seen in a mirror, is given.
OtherView right_view(DisparityMap mirrored, const InputPair& pair, const stages::FoundRange& range,
                     int threads) {
    OtherView right{{}, stages::mirrored(std::move(mirrored)), {}, pair.views.right, pair.pictures.right};
    for (Image* image : {&right.color, &right.picture})
        if (!image->empty()) matching::relight(*image, range.correction.light, threads);
    return right;
}

// Makes one texture of the left picture and those of the other views, and the mesh's parts refer to it.
void add_texture(SurfaceResult::OtherViews& others, const Image& left, SurfaceMesh& mesh) {
    if (left.empty()) return;
    std::vector<stages::PictureInUse> pictures;
    for (const OtherView& other : others.views) pictures.push_back({other.texture(), other.missing});
    others.atlas = stages::make_atlas(left, pictures);
    std::size_t first = 0;
    for (std::size_t i = 0; i < mesh.parts.size(); first += mesh.parts[i++].vertices)
        others.atlas.move_in(std::span(mesh.texcoords).subspan(first, mesh.parts[i].vertices), i);
}

}  // namespace

OtherView matched_right_view(const InputPair& pair, const StereoPair& corrected,
                             const stages::FoundRange& range, Backend& backend) {
    const int threads = backend.threads();
    return right_view(stages::match_range(stages::mirrored(corrected), range.config, backend, threads), pair,
                      range, threads);
}

OtherView right_view_of_program(const InputPair& pair, const stages::ViewMaps& maps,
                                const stages::FoundRange& range, int threads) {
    const stages::ViewMaps seen_in_mirror{stages::mirrored(maps.right), stages::mirrored(maps.left),
                                          maps.is_dense};
    return right_view(refine_given(stages::mirrored(pair.views), seen_in_mirror, range.config, threads), pair,
                      range, threads);
}

void complete_right_view(OtherView& right, const LeftView& left, const DisparityResult& disparity,
                         const readers::PixelMask& mask, int threads) {
    right.place = left_place(left);
    right.place.right = 1;
    right.place.shift_px = left.pair_camera.doffs_px - left.calibration.doffs_px;
    const float background_px = left.density.background_px;
    for (std::size_t i = 0; i < right.map.values.size(); ++i) {
        float& d = right.map.values[i];
        if (DisparityMap::known(d)) d = std::max(d + static_cast<float>(right.place.shift_px), left.least_px);
        if (d <= -left.calibration.doffs_px || d < background_px || (!mask.empty() && !mask.kept[i]))
            d = kUnknownDisparity;
    }
    if (const auto& noise = disparity.noise; noise.noise_px > 0)
        right.map = dequantize::dequantize(right.map, noise.quantum_px, threads, noise.smoothness);
}

void add_other_views(SurfaceResult& result, const LeftView& view, const config::Config& config,
                     Backend& backend, const RunLog& log) {
    const OtherView* const right = view.right;
    const double behind = is_without_background(view) ? 0 : config.surface.behind;
    const int threads = backend.threads();
    SurfaceMesh& mesh = result.mesh;
    SurfaceResult::OtherViews others;
    const auto add = [&](OtherView other, const stages::SeenSurface& here,
                         const stages::VisibleSurface& visible) {
        stages::join_to_surface(other, here);
        const DensityMap density = density_of_view(other.map, config.density, threads);
        const SurfaceMesh sheet = sheet_of(other, density, view, visible, config, backend, log);
        if (sheet.empty()) return;
        stages::append(mesh, sheet, other.place.right > 0 ? PartOrigin::right : PartOrigin::nobody);
        others.views.push_back(std::move(other));
    };
    if (right) {
        const stages::VisibleSurface visible = seen_by_cameras(mesh, view, threads);
        OtherView missing = *right;
        stages::find_missing(missing, visible.seen[1], visible.seen[0], threads);
        if (behind > 0)
            stages::continue_behind(missing, visible.seen[1], {.right = behind}, visible, threads);
        add(std::move(missing), visible.seen[1], visible);
    }
    if (behind > 0) {
        const stages::VisibleSurface visible = seen_by_cameras(mesh, view, threads);
        OtherView left = copy_of_left(view);
        const stages::SeenSurface& here = visible.seen[0];
        show(left, here);
        stages::continue_behind(
            left, here, {.left = behind, .right = right ? 0 : 1 + behind, .up = behind, .down = behind},
            visible, threads);
        add(std::move(left), here, visible);
    }
    if (others.views.empty()) return;
    add_texture(others, view.texture, mesh);
    log.decide("surface: " + std::to_string(mesh.triangles_of(PartOrigin::right)) +
               " triangles show what only the right camera sees, " +
               std::to_string(mesh.triangles_of(PartOrigin::nobody)) + " what neither sees");
    result.others = std::make_shared<const SurfaceResult::OtherViews>(std::move(others));
}

void add_other_views(SurfaceMesh& mesh, const SurfaceResult& finest, const LeftView& view,
                     const config::Config& config, Backend& backend, const RunLog& log) {
    if (!finest.others) return;
    const int threads = backend.threads();
    if (!view.texture.empty()) finest.others->atlas.move_in(mesh.texcoords, 0);
    for (std::size_t i = 0; i < finest.others->views.size(); ++i) {
        const OtherView& other = finest.others->views[i];
        const stages::VisibleSurface visible = seen_by_cameras(mesh, view, threads);
        SurfaceMesh sheet = sheet_of(other, density_of_view(other.map, config.density, threads), view,
                                     visible, config, backend, log);
        if (!view.texture.empty()) finest.others->atlas.move_in(sheet.texcoords, i + 1);
        stages::append(mesh, sheet, finest.mesh.parts[i + 1].origin);
    }
}

}  // namespace hexrelief::job
