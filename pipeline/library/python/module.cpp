// The module hexrelief._core, on which hexrelief/__init__.py is built. Arrays come in as pointers and strides
// that Python has checked.

#include <hexrelief/hexrelief.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <exception>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "pipeline/config/options.h"
#include "pipeline/data/error.h"
#include "pipeline/evaluation/evaluate.h"
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

// Adds evaluate() and measure_surface(), which return JSON, to the module.
void add_measures(py::module_& module) {
    module.def("evaluate", &evaluate);
    module.def("measure_surface", &measure_surface);
}

using Settings = std::vector<std::pair<std::string, std::string>>;

// What the work tells: functions of Python, of which progress may be None.
struct Listeners {
    const py::function& warn;
    const py::object& progress;
};

// Python's own thread checks for Ctrl-C whenever the work reports its progress. The callbacks are called
// without the interpreter's lock.
Options options_of(const std::vector<std::string>& config, const Settings& settings,
                   const Listeners& listeners) {
    Options options{.config = config, .settings = settings};
    options.progress = [&progress = listeners.progress](const std::string& stage, double share) {
        const py::gil_scoped_acquire lock;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (!progress.is_none()) progress(stage, share);
    };
    options.warn = [&warn = listeners.warn](const std::string& text) {
        const py::gil_scoped_acquire lock;
        warn(text);
    };
    return options;
}

// Rows may be any non-negative distance apart; a row itself has no gaps.
ImageView image_view(const std::optional<py::array>& array) {
    if (!array) return {};
    const int channels = array->ndim() == 3 ? static_cast<int>(array->shape(2)) : 1;
    return {static_cast<const std::uint8_t*>(array->data()), static_cast<int>(array->shape(1)),
            static_cast<int>(array->shape(0)), channels, static_cast<std::size_t>(array->strides(0))};
}

MapView map_view(const std::optional<py::array>& array) {
    if (!array) return {};
    const auto samples = array->itemsize() == 4   ? MapView::Samples::float32
                         : array->itemsize() == 2 ? MapView::Samples::uint16
                                                  : MapView::Samples::uint8;
    return {array->data(), static_cast<int>(array->shape(1)), static_cast<int>(array->shape(0)), samples,
            static_cast<std::size_t>(array->strides(0))};
}

// Returns a read-only array of data that `owner` holds; the array keeps the owner alive.
template <typename Value>
py::array lent(const Value* values, std::vector<py::ssize_t> shape, const py::object& owner) {
    py::array_t<Value> array(std::move(shape), values, owner);
    array.attr("flags").attr("writeable") = false;
    return array;
}

// Returns the array of a mesh's values, `columns` of each vertex or face.
template <auto values, auto count, py::ssize_t columns>
py::array rows_of(const py::object& self) {
    const auto& mesh = self.cast<const Mesh&>();
    return lent((mesh.*values)(), {static_cast<py::ssize_t>((mesh.*count)()), columns}, self);
}

// Returns an array of a vector that `holder` holds; the array keeps the whole holder alive.
template <typename Holder, typename Value>
py::array owned(std::unique_ptr<Holder> holder, std::vector<Value> Holder::*member,
                std::vector<py::ssize_t> shape) {
    Value* const values = (holder.get()->*member).data();
    const py::capsule owner(holder.release(), [](void* object) { delete static_cast<Holder*>(object); });
    return py::array_t<Value>(std::move(shape), values, owner);
}

py::array compute_disparity_of(const py::array& left, const py::array& right, const Camera& camera,
                               const std::vector<std::string>& config, const Settings& settings,
                               const py::function& warn, const py::object& progress) {
    const ImageView left_view = image_view(left), right_view = image_view(right);
    const Options options = options_of(config, settings, {warn, progress});
    auto found = std::make_unique<Disparities>();
    {
        const py::gil_scoped_release unlocked;
        *found = compute_disparity(left_view, right_view, camera, options);
    }
    const py::ssize_t width = found->width, height = found->height;
    return owned(std::move(found), &Disparities::values, {height, width});
}

// Makes a mesh from the arrays of a map, each None or an array, by their names in MapInput.
Mesh mesh_of(const std::map<std::string, std::optional<py::array>>& arrays, const Camera& camera,
             const std::vector<std::string>& config, const Settings& settings, const py::function& warn,
             const py::object& progress) {
    const MapInput input{map_view(arrays.at("disparity")), map_view(arrays.at("depth")),
                         image_view(arrays.at("color")), image_view(arrays.at("mask")),
                         map_view(arrays.at("confidence"))};
    const Options options = options_of(config, settings, {warn, progress});
    const py::gil_scoped_release unlocked;
    return mesh_input(input, camera, options);
}

std::vector<std::string> save(const Mesh& mesh, const std::string& path, const Settings& settings,
                              const py::function& warn, const py::object& progress) {
    const Options options = options_of({}, settings, {warn, progress});
    const py::gil_scoped_release unlocked;
    return mesh.save(path, options);
}

// Copies bytes from a device's memory to the host.
py::array_t<std::uint8_t> from_device(std::uintptr_t address, std::size_t bytes) {
    py::array_t<std::uint8_t> here(static_cast<py::ssize_t>(bytes));
    std::uint8_t* const target = here.mutable_data();
    const py::gil_scoped_release unlocked;
    job::copy_from_device(target, reinterpret_cast<const void*>(address), bytes);
    return here;
}

// Returns the key that an option of the command line sets; empty if there is none, or more than one.
std::string key_of(const std::string& flag) {
    const std::vector<const config::Field*> rows = config::rows_of_option(flag);
    return rows.size() == 1 ? rows.front()->path : "";
}

const std::map<ErrorKind, const char*> kKindNames = {{ErrorKind::usage, "usage"},
                                                     {ErrorKind::input, "input"},
                                                     {ErrorKind::output, "output"},
                                                     {ErrorKind::device, "device"}};

void add_error(py::module_& module) {
    // Never released: an exception may come as long as the process lives.
    static const py::handle type = PyErr_NewException("hexrelief.Error", PyExc_RuntimeError, nullptr);
    module.attr("Error") = type;
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown) std::rethrow_exception(thrown);
        } catch (const Error& error) {
            const py::object in_python = py::module_::import("hexrelief._words").attr("in_python");
            py::object object = type(in_python(error.what()));
            object.attr("kind") = kKindNames.at(error.kind());
            object.attr("exit_code") = static_cast<int>(error.kind());
            PyErr_SetObject(type.ptr(), object.ptr());
        }
    });
}

}  // namespace

PYBIND11_MODULE(_core, module) {
    add_error(module);
    module.attr("version") = version();
    py::class_<Camera>(module, "Camera")
        .def(py::init([](const std::string& file, double focal_px, double baseline_m, double cx, double cy,
                         double doffs_px) { return Camera{file, focal_px, baseline_m, cx, cy, doffs_px}; }));
    py::class_<Mesh>(module, "Mesh")
        .def("vertices", rows_of<&Mesh::vertices, &Mesh::vertex_count, 3>)
        .def("faces", rows_of<&Mesh::faces, &Mesh::face_count, 3>)
        .def("uv", rows_of<&Mesh::uv, &Mesh::vertex_count, 2>)
        .def("lattice",
             [](const py::object& self) {
                 const auto& mesh = self.cast<const Mesh&>();
                 return lent(mesh.lattice(), {mesh.lattice_rows(), mesh.lattice_columns(), 2}, self);
             })
        .def("disparity",
             [](const py::object& self) {
                 const MapView map = self.cast<const Mesh&>().disparity();
                 return lent(static_cast<const float*>(map.values), {map.height, map.width}, self);
             })
        .def("is_metric", &Mesh::is_metric)
        .def("report", &Mesh::report, py::call_guard<py::gil_scoped_release>())
        .def("save", &save);
    add_measures(module);
    module.def("compute_disparity", &compute_disparity_of);
    module.def("mesh", &mesh_of);
    module.def("key_of", &key_of);
    module.def("from_device", &from_device);
    module.def("read_disparity", [](const std::string& path, const Settings& settings) {
        auto map = std::make_unique<Disparities>(read_disparities(path, {.settings = settings}));
        const py::ssize_t width = map->width, height = map->height;
        return owned(std::move(map), &Disparities::values, {height, width});
    });
    module.def("read_picture", [](const std::string& path) {
        auto picture = std::make_unique<Picture>(read_picture(path));
        const py::ssize_t width = picture->width, height = picture->height, channels = picture->channels;
        return owned(std::move(picture), &Picture::pixels, {height, width, channels});
    });
}

}  // namespace hexrelief::library
