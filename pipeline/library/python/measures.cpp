// Figures of maps and of surfaces against a true map: what `hexrelief evaluate` and `--report` have, of
// arrays.
#include "pipeline/library/python/measures.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "pipeline/config/options.h"
#include "pipeline/data/error.h"
#include "pipeline/evaluation/evaluation_json.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/report.h"
#include "pipeline/stages/density.h"
#include "pipeline/stages/other_views/hole_shares.h"
#include "pipeline/stages/surface_quality.h"

namespace py = pybind11;

namespace hexrelief::library {
namespace {

template <typename Value>
using Array = py::array_t<Value, py::array::c_style>;

DisparityMap map_of(const Array<float>& array) {
    if (array.ndim() != 2) throw Error(ErrorKind::input, "a map has two dimensions: rows and columns");
    return {static_cast<int>(array.shape(1)),
            static_cast<int>(array.shape(0)),
            {array.data(), array.data() + array.size()},
            {}};
}

std::string evaluate(const Array<float>& disparity, const Array<float>& truth,
                     const std::optional<Array<float>>& right_truth, double discontinuity_px) {
    const DisparityMap map = map_of(disparity), true_map = map_of(truth);
    evaluation::EvaluationConfig config{.discontinuity_px = discontinuity_px};
    DisparityMap right;
    if (right_truth) {
        right = map_of(*right_truth);
        config.right_truth = &right;
    }
    const py::gil_scoped_release unlocked;
    return evaluation::evaluation_json(evaluation::evaluate_disparity(map, true_map, config)).dump();
}

SurfaceMesh surface_of(const Array<float>& points, const Array<std::uint32_t>& faces) {
    if (points.ndim() != 2 || points.shape(1) != 3 || faces.ndim() != 2 || faces.shape(1) != 3)
        throw Error(ErrorKind::input, "points have the shape (N, 3), faces (M, 3)");
    SurfaceMesh mesh;
    const float* const p = points.data();
    for (py::ssize_t i = 0; i < points.size(); i += 3) {
        mesh.image_points.push_back({p[i], p[i + 1]});
        mesh.disparities.push_back(p[i + 2]);
    }
    const std::uint32_t* const f = faces.data();
    for (py::ssize_t i = 0; i < faces.size(); i += 3) {
        for (int corner = 0; corner < 3; ++corner)
            if (f[i + corner] >= mesh.disparities.size())
                throw Error(ErrorKind::input, "faces: vertex " + std::to_string(f[i + corner]) + " of " +
                                                  std::to_string(mesh.disparities.size()));
        mesh.triangles.push_back({f[i], f[i + 1], f[i + 2]});
    }
    return mesh;
}

std::string measure_surface(const Array<float>& points, const Array<std::uint32_t>& faces,
                            const Array<float>& truth, const std::vector<std::string>& names,
                            const std::vector<std::pair<std::string, std::string>>& settings) {
    const SurfaceMesh mesh = surface_of(points, faces);
    const DisparityMap map = map_of(truth);
    const py::gil_scoped_release unlocked;
    std::vector<std::string> texts;
    for (const auto& [key, value] : settings) texts.push_back(key + "=" + value);
    const config::Config config = config::read_config(names, texts);
    const int threads = job::effective_threads(config.run.threads);
    const float background_px = stages::compute_density(map, config.density).background_px;
    const stages::SurfaceQuality quality = stages::measure_surface_quality(mesh, map, background_px, threads);
    const stages::HoleShares holes = stages::measure_holes(mesh, map, 0, threads);
    return job::surface_figures_json(quality, holes).dump();
}

}  // namespace

void add_measures(py::module_& module) {
    module.def("evaluate", &evaluate);
    module.def("measure_surface", &measure_surface);
}

}  // namespace hexrelief::library
