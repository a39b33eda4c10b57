#include "pipeline/job/page_content.h"

#include <algorithm>
#include <future>
#include <utility>

#include "exporters/mesh_formats.h"
#include "mesher/mesher.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/start_work.h"
#include "pipeline/job/pictures/relief_picture.h"
#include "pipeline/job/pictures/stage_pictures.h"
#include "pipeline/job/pictures/weights_picture.h"

namespace hexrelief::job {

bool has_page(const std::vector<std::filesystem::path>& outputs) {
    return std::any_of(outputs.begin(), outputs.end(), [](const std::filesystem::path& path) {
        return exporters::export_format(path).is_page;
    });
}

exporters::PageContent page_content(const LeftView& view, const SurfaceResult& result,
                                    const stages::SurfaceQuality& quality, int threads) {
    const HexMesh2D& lattice = result.lattice;
    std::future<Image> relief =
        start_work(threads, [&] { return job::render_relief(result.mesh, result.texture(view)); });
    const Image disparities = job::disparity_picture(view.meshed);
    exporters::PageContent page;
    const auto add = [&](const char* name, const char* label, Image image) {
        page.pictures.push_back({name, label, std::move(image)});
    };
    add("disparity", "Disparities, yellow is near", disparities);
    add("density", "Density that the lattice is adapted to", job::density_picture(view.density));
    add("mesh2d", "The adapted lattice",
        job::mesh_picture(lattice, view.color.empty() ? disparities : view.color));
    add("weights", "How equal its honeycomb cells are",
        job::weights_picture(quality::honeycomb_weights(lattice, view.density, threads)));

    add("relief", "The relief, seen from the side", relief.get());

    const Bounds bounds = bounds_of(result.mesh.positions);  // the camera looks along -Z
    const char* const unit = result.mesh.metric ? "m" : "relative";
    page.figures = {
        {"Nearest", -bounds.high.z, 2, unit},
        {"Farthest", -bounds.low.z, 2, unit},
        {"Of the picture meshed", 100 * quality.coverage, 1, "%"},
        {"Error, both views", quality.duo_rmse_near_px, 3, "px"},
        {"Error, left view", quality.rmse_near_px, 3, "px"},
        {"Lattice vertices", static_cast<double>(lattice.positions.size()), 0, ""},
        {"%cost", result.quality.percent_cost, 2, ""},
    };
    return page;
}

}  // namespace hexrelief::job
