#include "pipeline/job/other_views.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "exporters/images/resize.h"
#include "mesher/mesher.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/job/right_view.h"
#include "pipeline/job/surfaces.h"
#include "pipeline/stages/other_views/backing.h"
#include "pipeline/stages/other_views/backing_texture.h"
#include "pipeline/stages/other_views/behind_silhouettes.h"
#include "pipeline/stages/other_views/beyond_left.h"
#include "pipeline/stages/other_views/bridges.h"
#include "pipeline/stages/other_views/other_view.h"
#include "pipeline/stages/other_views/pieces.h"
#include "pipeline/stages/other_views/small_regions.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::job {
namespace {

using stages::OtherView;
using stages::ViewPlace;

// Nobody saw what continues: of rectified pairs and maps it is shown at less than the texture's size.
constexpr int kReduced = 2;
constexpr double kCoarser = 3.5;  // spacing of the other views: what has no match has little detail
constexpr double kHiddenStepShare = 1. / 70;  // of the left view's width: hidden_step_px()
constexpr double kBlade_px = 20;              // what moving made step by more is dropped
// A higher step is cut in what the right camera sees some of, but has no view of.
constexpr double kShownStep_px = 6;
// So far sheets overlap with what is around them; more joins those of a pair's view on one surface.
constexpr int kBorder_px = 2, kBorderOfPairs_px = 6;
// Pairs: pixels of about one triangle of a sheet, which is no surface of its own; and of a part that stands
// alone only if it is farther from others than two bridges reach.
constexpr std::size_t kLeastOfPairs = 240, kLeastAlone = 5000;
constexpr int kBridge_px = 64;
// Pieces of fewer triangles stand alone only if no strip of this length that nobody sees leads to others.
constexpr std::size_t kLeastPiece = 30;
constexpr double kStrip_px = 128;
constexpr std::size_t kFirstSheet = 2;    // part: the left view and its strips are before
constexpr double kFarther = 127. / 128;   // share of the least disparity
constexpr double kMostBackground = 0.01;  // share of a view that is dropped and hardly opens it
constexpr double kLeastSpacing_px = 4;
constexpr double kFittingSpacings = 4;  // of regular_mesh() in the shorter side

// A higher step is cut in what no camera saw. In a backing, which is smooth, it is much higher.
double hidden_step_px(const LeftView& view) {
    return std::max(kShownStep_px, kHiddenStepShare * view.disparity.width);
}

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

// True if a view's part goes on beyond the left photograph's frame. Where a mask or the background ends the
// left view, it does not.
bool goes_beyond_left(const OtherView& other, const LeftView& left) {
    return left.is_by_points && other.place.right > 0 && !left.is_masked && !is_without_background(left);
}

// The left view with nothing missing yet.
OtherView copy_of_left(const LeftView& view, int threads) {
    OtherView left{left_place(view), {}, {}, view.color};
    left.missing = {left.place.width, left.place.height,
                    std::vector<float>(view.disparity.values.size(), kUnknownDisparity)};
    const int reduced = view.is_by_points ? 1 : kReduced, width = view.texture.width / reduced,
              height = view.texture.height / reduced;
    if (width < view.color.width && std::min(width, height) > 0)
        left.picture = exporters::resized(view.color, width, height, threads);
    return left;
}

// The spacing of a missing part's lattice, in px of its view.
double spacing_of(const OtherView& other, const config::Config& config) {
    return std::min(std::max(kCoarser * config.mesh.spacing_px / other.place.scale, kLeastSpacing_px),
                    std::min(other.place.width, other.place.height) / kFittingSpacings);
}

// Returns the missing part as triangles, some of which may be in front of what cameras see. The CPU cuts it,
// as two parts are cut at once.
DisparityMesh cut_part(const OtherView& other, const LeftView& left, const config::Config& config,
                       int threads, const RunLog& log) {
    const Calibration camera = stages::camera_at(other.place, left.calibration);
    const int width = other.place.width, height = other.place.height;
    const DensityMap even{width, height, std::vector<float>(other.missing.values.size(), 0)};
    const Image none;  // the part's picture is painted meanwhile
    const LeftView view{
        other.missing, other.missing, even,   none,
        none,          camera,        camera, left.least_px / static_cast<float>(other.place.scale)};
    MeshConfig coarse = config.mesh;
    coarse.spacing_px = spacing_of(other, config);
    SurfaceConfig surface = config.surface;
    // Nobody knows exactly where what no camera saw ends.
    if (other.place.right == 0) surface.split_rounds = std::min(surface.split_rounds, 1);
    if (other.place.right == 0 || left.is_by_points)
        surface.least_discontinuity_px = left.right ? hidden_step_px(left) : kShownStep_px;
    const BackendPointer cpu = pick_backend(config::BackendChoice::cpu, threads);
    return cut_lattice(mesher::regular_mesh(width, height, coarse), view, surface, *cpu, log);
}

// Returns a cut part as a surface in the left camera's space; empty if there is nothing large enough.
SurfaceMesh sheet_of(DisparityMesh cut, const OtherView& other, const LeftView& left,
                     const stages::VisibleSurface& visible, const stages::Frame& frame,
                     const config::Config& config, int threads) {
    const ViewPlace& place = other.place;
    if (goes_beyond_left(other, left))
        stages::drop_not_shown(cut, other);
    else if (left.is_by_points)
        stages::move_into_frame(cut, place, frame, visible.seen[0],
                                static_cast<int>(std::ceil(spacing_of(other, config) * place.scale)));
    stages::keep_behind(cut, place, visible, kBlade_px, threads);
    if (cut.triangles.empty()) return {};
    try {
        SurfaceMesh sheet = stages::in_left_space(
            stages::build_surface(cut, place.width, place.height, stages::camera_at(place, left.calibration),
                                  config.surface.min_component),
            place, left.calibration);
        // The backing's view leaves out what is left over of the left view's columns and rows; its picture
        // does not.
        const auto across = static_cast<float>(place.width * place.scale / left.disparity.width),
                   down = static_cast<float>(place.height * place.scale / left.disparity.height);
        for (Vec2f& at : sheet.texcoords) at = {across * at.x, down * at.y};
        return sheet;
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        return {};  // all components are too small
    }
}

void move_into_atlas(SurfaceMesh& mesh, const stages::TextureAtlas& atlas) {
    std::size_t first = 0;
    for (std::size_t i = 0; i < mesh.parts.size(); first += mesh.parts[i++].vertices)
        atlas.move_in(std::span(mesh.texcoords).subspan(first, mesh.parts[i].vertices),
                      i < kFirstSheet ? 0 : i - kFirstSheet + 1);
}

// Returns the left view's frame for what ends there; empty where nothing does.
stages::Frame frame_for(const LeftView& view, const stages::VisibleSurface& visible,
                        const config::Config& config) {
    return view.is_by_points ? stages::frame_of(visible.seen[0], config.surface.behind) : stages::Frame{};
}

// Joins the pieces of the left view's surface and those of the sheets, and appends these. The strips between
// the left view's pieces are a part of their own: neither measures nor solids of that view have them. Calls
// use_sheets() before they are appended.
template <class UseSheets>
void join_and_append(SurfaceMesh& mesh, std::vector<SurfaceMesh>& sheets, const std::vector<OtherView>& views,
                     const stages::VisibleSurface& visible, const LeftView& view, int threads,
                     const UseSheets& use_sheets) {
    const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
    const auto join = [&](SurfaceMesh& part) {
        stages::join_pieces(part, visible, view.calibration, {kLeastPiece, kStrip_px, view.is_by_points});
    };
    auto joining_left = start_work(threads, [&] { join(mesh); });  // the largest
    std::ranges::for_each(sheets, join);
    use_sheets();
    joining_left.get();
    mesh.parts = {{PartOrigin::left, vertices, triangles},
                  {PartOrigin::nobody, mesh.positions.size() - vertices, mesh.triangles.size() - triangles}};
    for (std::size_t i = 0; i < sheets.size(); ++i)
        stages::append(mesh, sheets[i], views[i].place.right > 0 ? PartOrigin::right : PartOrigin::nobody);
}

// What cameras see of the surface, and how far beside them others look behind it, in baselines.
struct SeenFrom {
    const LeftView& view;
    const stages::VisibleSurface& visible;
    const stages::Frame& frame;
    const config::Config& config;
    const RunLog& log;
    double behind;
    int threads;

    bool is_rectified() const { return view.right && !view.is_by_points; }
    int mixed_px() const {
        return view.is_by_points ? stages::Beyond::kMixedOfPhotographs_px : stages::Beyond::kMixed_px;
    }
    void join_to_surface(OtherView& other, const stages::SeenSurface& here) const {
        stages::join_to_surface(other, here, is_rectified() ? kBorderOfPairs_px : kBorder_px,
                                is_rectified() ? kLeastOfPairs : stages::kLeastSurface, threads);
    }
    DisparityMesh cut(const OtherView& part) const { return cut_part(part, view, config, threads, log); }
    SurfaceMesh sheet(DisparityMesh cut, const OtherView& part) const {
        return sheet_of(std::move(cut), part, view, visible, frame, config, threads);
    }
};

// A missing part and its surface, or first its triangles.
struct Part {
    OtherView view;
    DisparityMesh cut;
    SurfaceMesh sheet;
};

// Returns what the right camera sees and the surface does not show, and what continues behind that and the
// surface in its view, with its sheet.
Part missing_on_right(const SeenFrom& seen) {
    const LeftView& view = seen.view;
    const stages::SeenSurface& here = seen.visible.seen[1];
    Part part{*view.right, {}, {}};
    OtherView& missing = part.view;
    if (missing.map.values.empty()) {
        missing.map = map_by_surface(*view.right, here, view, seen.threads);
        drop_background(missing, view.density.background_px);
    }
    stages::find_missing(missing, here, seen.visible.seen[0], view.is_by_points, seen.threads);
    missing.map = {};
    const std::vector<std::uint8_t> is_shown = stages::known_pixels(missing.missing);
    std::optional<stages::Behind> hidden;
    if (seen.behind > 0)
        hidden = stages::continue_behind(missing, here, {.right = seen.behind, .mixed_px = seen.mixed_px()},
                                         seen.visible, seen.threads);
    auto painting = start_work(seen.threads, [&] {
        if (hidden) stages::paint_behind(missing, *std::move(hidden), nullptr, seen.threads);
    });
    if (view.is_by_points) stages::keep_in_frame(missing, seen.frame);
    if (goes_beyond_left(missing, view)) stages::continue_beyond_left(missing, here);
    seen.join_to_surface(missing, here);
    std::vector<stages::BridgePixel> bridges;
    if (seen.is_rectified()) {
        stages::ramp_steps(missing.missing, is_shown, hidden_step_px(view));
        bridges =
            stages::join_regions(missing.missing, here, kLeastAlone, kBridge_px, stages::kOneSurface_px);
    }
    part.sheet = seen.sheet(seen.cut(missing), missing);
    painting.get();
    stages::paint_bridges(missing, bridges);
    return part;
}

// Returns what continues behind the surface in the left view, and the backing, as triangles.
std::pair<Part, Part> hidden_on_left(const SeenFrom& seen) {
    const LeftView& view = seen.view;
    const stages::SeenSurface& here = seen.visible.seen[0];
    auto finding_backing = start_work(seen.threads, [&] {
        return stages::backing_of(here, view.color, seen.behind, seen.visible.least_px, seen.threads);
    });
    Part left{copy_of_left(view, seen.threads), {}, {}};
    stages::Behind hidden = stages::continue_behind(
        left.view, here,
        {seen.behind, view.right ? 0 : 1 + seen.behind, seen.behind, seen.behind, seen.mixed_px()},
        seen.visible, seen.threads);
    Part backing{finding_backing.get(), {}, {}};
    stages::keep_behind_continued(backing.view, left.view.missing);
    auto painting = start_work(seen.threads, [&] {
        stages::paint_behind(left.view, std::move(hidden), &backing.view, seen.threads);
    });
    seen.join_to_surface(left.view, here);
    std::vector<stages::BridgePixel> bridges;
    if (seen.is_rectified())
        bridges =
            stages::join_regions(left.view.missing, here, kLeastAlone, kBridge_px, hidden_step_px(view));
    left.cut = seen.cut(left.view);
    painting.get();
    stages::paint_bridges(left.view, bridges);
    if (seen.is_rectified()) stages::join_backing(backing.view, kLeastAlone, kBridge_px);
    backing.cut = seen.cut(backing.view);
    return {std::move(left), std::move(backing)};
}

}  // namespace

void add_other_views(SurfaceResult& result, const LeftView& view, const config::Config& config, int threads,
                     const RunLog& log) {
    const OtherView* const right = view.right;
    const double behind = is_without_background(view) ? 0 : config.surface.behind;
    if (!right && behind == 0) return;
    SurfaceMesh& mesh = result.mesh;
    SurfaceResult::OtherViews others;
    std::vector<SurfaceMesh> sheets;
    // The picture is large, and copied meanwhile: it gets more colours than it has.
    auto copying_left = start_work(threads, [&] { return stages::with_room_below(view.texture); });
    stages::VisibleSurface visible = seen_by_cameras(mesh, view, threads);
    const stages::Frame frame = frame_for(view, visible, config);
    const auto add = [&](Part part) {
        if (part.sheet.empty()) return;
        sheets.push_back(std::move(part.sheet));
        others.views.push_back(std::move(part.view));
    };
    // Both views' parts are found at once, each cut while it is painted: a third of the threads is best.
    const int share = right && behind > 0 ? (threads + 2) / 3 : threads;
    const SeenFrom seen{view, visible, frame, config, log, behind, share};
    auto finding_right =
        start_work(threads, [&] { return right ? std::optional(missing_on_right(seen)) : std::nullopt; });
    std::optional<std::pair<Part, Part>> hidden;
    if (behind > 0) hidden = hidden_on_left(seen);
    if (std::optional<Part> found = finding_right.get()) {
        stages::cover(visible, found->sheet, threads);
        add(*std::move(found));
    }
    if (hidden)
        for (Part* part : {&hidden->first, &hidden->second}) {
            if (part->view.is_backing) visible.least_px *= kFarther;
            part->sheet = sheet_of(std::move(part->cut), part->view, view, visible, frame, config, threads);
            add(std::move(*part));
        }
    if (others.views.empty()) return;
    join_and_append(mesh, sheets, others.views, visible, view, threads, [&] {
        Image left = copying_left.get();
        if (left.empty()) return;
        std::vector<stages::PictureInUse> pictures;
        for (std::size_t i = 0; i < sheets.size(); ++i) {
            const Image& picture = others.views[i].texture();
            pictures.push_back(
                {picture, stages::used_part(picture, sheets[i], config.exporting.lod > 1, threads)});
        }
        others.atlas = stages::make_atlas(std::move(left), pictures, threads);
    });
    if (!view.texture.empty()) move_into_atlas(mesh, others.atlas);
    mesh.provenance = stages::provenance_of(mesh, visible.seen, threads);
    log.decide("surface: " + std::to_string(mesh.triangles_of(PartOrigin::right)) +
               " triangles show what only the right camera sees, " +
               std::to_string(mesh.triangles_of(PartOrigin::nobody)) + " what neither sees");
    result.others = std::make_shared<const SurfaceResult::OtherViews>(std::move(others));
}

void add_other_views(SurfaceMesh& mesh, const SurfaceResult& finest, const LeftView& view,
                     const config::Config& config, int threads, const RunLog& log) {
    if (!finest.others) return;
    stages::VisibleSurface visible = seen_by_cameras(mesh, view, threads);
    const stages::Frame frame = frame_for(view, visible, config);
    std::vector<SurfaceMesh> sheets;
    for (std::size_t i = 0; i < finest.others->views.size(); ++i) {
        const OtherView& other = finest.others->views[i];
        if (other.is_backing) visible.least_px *= kFarther;
        sheets.push_back(sheet_of(cut_part(other, view, config, threads, log), other, view, visible, frame,
                                  config, threads));
        if (other.place.right > 0) stages::cover(visible, sheets.back(), threads);
    }
    join_and_append(mesh, sheets, finest.others->views, visible, view, threads, [] {});
    if (!view.texture.empty()) move_into_atlas(mesh, finest.others->atlas);
    mesh.provenance = stages::provenance_of(mesh, visible.seen, threads);
}

}  // namespace hexrelief::job
