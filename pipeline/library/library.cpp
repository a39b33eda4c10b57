#include <hexrelief/run.h>

#include <algorithm>
#include <filesystem>
#include <mutex>

#include "pipeline/files/interrupt.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/report.h"
#include "pipeline/job/run_files.h"
#include "pipeline/job/runner.h"
#include "pipeline/job/tolerance.h"
#include "pipeline/library/arguments.h"
#include "pipeline/library/requests.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/stamp/stamp.h"

namespace hexrelief {
namespace {

// Held by each call that works: a set of files is the process's own, and a device does one job at a time.
std::mutex library_mutex;

RunObserver observer_of(const Options& options) {
    RunObserver observer;
    if (options.progress) {
        const auto stage = std::make_shared<std::string>();
        observer.stage_begins = [stage, tell = options.progress](const std::string& name) {
            tell(*stage = name, 0);
        };
        observer.stage_progresses = [stage, tell = options.progress](double share) { tell(*stage, share); };
    }
    observer.warns = options.warn;
    observer.stage_ends = options.stage_ended;
    observer.decides = options.decided;
    return observer;
}

// The first device that is taken is kept: the next call need not wait for it to start. It is never given
// back, for at the process's end the driver may be gone before.
const BackendPicker& kept_backends() {
    static const auto* const picker = new BackendPicker(keep_backends());
    return *picker;
}

MapArrays arrays_of(const MapInput& input, const InputConfig& config) {
    MapArrays arrays;
    if (input.depth.values)
        arrays.depth = depth_of(input.depth, config.depth);
    else
        arrays.disparity = map_of(input.disparity, config.disparity);
    if (input.color.pixels) arrays.color = image_of(input.color, "color");
    if (input.mask.pixels) arrays.mask = mask_of(input.mask, config.mask);
    if (input.confidence.values) arrays.confidence = confidence_of(input.confidence, config.confidence);
    return arrays;
}

const float* floats_of(const std::vector<Vec2f>& points) {
    static_assert(sizeof(Vec2f) == 2 * sizeof(float));
    return points.empty() ? nullptr : &points.front().x;
}

const float* floats_of(const std::vector<Vec3f>& points) {
    static_assert(sizeof(Vec3f) == 3 * sizeof(float));
    return points.empty() ? nullptr : &points.front().x;
}

}  // namespace

inline namespace v0 {

struct Mesh::State {
    RunObserver observer;  // the log's, empty between the calls
    RunLog log{observer};
    RunRequest request;
    Relief relief;
    std::vector<OutputFile> written;

    const SurfaceMesh& surface() const { return relief.result.surface.mesh; }
};

Mesh::Mesh(std::unique_ptr<State> state) : state_(std::move(state)) {}
Mesh::Mesh(Mesh&&) noexcept = default;
Mesh& Mesh::operator=(Mesh&&) noexcept = default;
Mesh::~Mesh() = default;

const float* Mesh::vertices() const {
    return floats_of(state_->surface().positions);
}
std::size_t Mesh::vertex_count() const {
    return state_->surface().positions.size();
}
const std::uint32_t* Mesh::faces() const {
    return state_->surface().triangles.data()->data();
}
std::size_t Mesh::face_count() const {
    return state_->surface().triangles.size();
}
const float* Mesh::uv() const {
    return floats_of(state_->surface().texcoords);
}
bool Mesh::is_metric() const {
    return state_->surface().metric;
}
const float* Mesh::lattice() const {
    return floats_of(state_->relief.result.lattice.mesh.positions);
}
int Mesh::lattice_columns() const {
    return state_->relief.result.lattice.mesh.columns;
}
int Mesh::lattice_rows() const {
    return state_->relief.result.lattice.mesh.rows;
}

std::string Mesh::report() const {
    const std::lock_guard lock(library_mutex);
    const Relief& relief = state_->relief;
    const LeftView view = relief.view();
    const RunContext run{relief.backend, relief.threads, state_->log};
    std::vector<std::filesystem::path> paths;
    for (const OutputFile& file : state_->written) paths.emplace_back(file.path);
    std::erase_if(paths, [](const auto& path) { return !find_mesh_format(path); });  // textures and the like
    const SurfaceMeasures measures = measure_written(view, relief.result, paths, run);
    return report_json(assemble_report({relief.backend_reason,
                                        relief.input,
                                        relief.disparity,
                                        view,
                                        relief.result,
                                        measures,
                                        {},
                                        state_->written,
                                        shares_of(view, relief.result)},
                                       run));
}

std::vector<std::string> Mesh::save(const std::string& path, const Options& options) const {
    const std::lock_guard lock(library_mutex);
    State& state = *state_;
    // For this call alone.
    struct Restore {
        State& state;
        const Config config = state.relief.result.config;
        ~Restore() {
            state.relief.result.config = config;
            state.observer = {};
        }
    } restore{state};
    state.observer = observer_of(options);
    Config& config = state.relief.result.config;
    apply_export_settings(config, options);
    if (sets_tolerance(options))
        config = with_tolerance(config, state.surface(), state.relief.view(),
                                {state.relief.backend, state.relief.threads, state.log});
    RunRequest request = state.request;
    request.config = config;
    request.outputs = {path};
    for (const std::filesystem::path& file : planned_files(path, config.exporting)) check_writable_file(file);
    const RunReport report = write_relief(state.relief, request, state.log);
    std::vector<std::string> files;
    for (const OutputFile& file : report.outputs) {
        std::erase_if(state.written, [&](const OutputFile& other) { return other.path == file.path; });
        state.written.push_back(file);
        files.push_back(file.path);
    }
    return files;
}

Picture read_picture(const std::string& path) {
    Image image = read_image(path);
    if (image.alpha.empty()) return {image.width, image.height, image.channels, std::move(image.pixels)};
    const auto channels = static_cast<std::size_t>(image.channels);
    Picture picture{image.width, image.height, image.channels + 1, {}};
    picture.pixels.reserve(image.alpha.size() * (channels + 1));
    for (std::size_t i = 0; i < image.alpha.size(); ++i) {
        const std::uint8_t* const colors = image.pixels.data() + i * channels;
        picture.pixels.insert(picture.pixels.end(), colors, colors + channels);
        picture.pixels.push_back(image.alpha[i]);
    }
    return picture;
}

Disparities read_disparities(const std::string& path, const Options& options) {
    const Config config = config_of(options, {});
    DisparityMap map = read_disparity_map(path, config.input.disparity, config.limits.reading);
    return {map.width, map.height, std::move(map.values)};
}

Disparities compute_disparity(const ImageView& left, const ImageView& right, const Camera& camera,
                              const Options& options) {
    const std::lock_guard lock(library_mutex);
    RunRequest request;
    request.config = config_of(options, camera);
    const RunObserver observer = observer_of(options);
    RunLog log(observer);
    Relief relief = make_disparities(
        [&](int, RunLog& told) {
            return take_pair({image_of(left, "left"), image_of(right, "right")}, request, told);
        },
        request, kept_backends(), log);
    DisparityMap& map = relief.disparity.map;
    return {map.width, map.height, std::move(map.values)};
}

Mesh mesh_input(const MapInput& input, const Camera& camera, const Options& options) {
    const std::lock_guard lock(library_mutex);
    const bool is_depth = input.depth.values != nullptr;
    if (is_depth && input.disparity.values != nullptr)
        throw Error(ErrorKind::usage, "disparities or depths, not both");
    auto state = std::make_unique<Mesh::State>();
    state->observer = observer_of(options);
    RunRequest& request = state->request;
    request.config = config_of(options, camera, is_depth);
    request.outputs = {"relief.glb"};
    if (is_depth) request.depth = "depth";
    state->relief = make_relief(
        [&](int, RunLog& told) { return take_map(arrays_of(input, request.config.input), request, told); },
        request, kept_backends(), state->log);
    state->observer = {};
    return Mesh(std::move(state));
}

Mesh mesh(const MapView& disparity, const ImageView& color, const Camera& camera, const Options& options) {
    return mesh_input({.disparity = disparity, .color = color}, camera, options);
}

RunSummary run(const FileRequest& files, const Options& options) {
    const std::lock_guard lock(library_mutex);
    RunRequest request = request_of(files, options);
    if (files.update) {
        check_request(request);
        if (stamp_request(request) == UnitState::current) return {.is_up_to_date = true};
    }
    const RunObserver observer = observer_of(options);
    const BackendPicker pick = files.ends_process ? pick_for_one_run() : kept_backends();
    return summary_of(run_job(request, observer, pick), request);
}

void check_run(const FileRequest& files, const Options& options) {
    check_request(request_of(files, options));
}

void end_on_interrupt() {
    install_interrupt_handling();
}

std::string version() {
    return HEXRELIEF_VERSION;
}

}  // namespace v0
}  // namespace hexrelief
