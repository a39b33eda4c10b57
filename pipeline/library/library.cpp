#include <hexrelief/run.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <mutex>

#include "pipeline/files/interrupt.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/report.h"
#include "pipeline/job/run_files.h"
#include "pipeline/job/runner.h"
#include "pipeline/job/stamp/stamp.h"
#include "pipeline/job/surfaces.h"
#include "pipeline/library/conversions.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"

namespace hexrelief {
namespace {

// Held during each call: the process has one set of files to undo, and a device does one job at a time.
std::mutex library_mutex;

// Keeps the first device that is used, so that the next call need not wait for its start. The backends are
// never destroyed, because at the process's end the driver may be gone first.
job::Backends& kept_backends() {
    static auto* const backends = new job::Backends;
    return *backends;
}

// The format that a limit on bytes applies to when a map in memory is meshed.
constexpr const char* kLimitedOutput = "relief.glb";

template <typename Arrays>
Arrays with_views(Arrays arrays, const MapInput& input, const config::InputConfig& config) {
    if (input.color.pixels) arrays.color = library::image_of(input.color, "color");
    if (input.mask.pixels) arrays.mask = library::mask_of(input.mask, config.mask);
    if (input.confidence.values)
        arrays.confidence = library::confidence_of(input.confidence, config.confidence);
    return arrays;
}

job::Source source_of(const MapInput& input, const config::InputConfig& config) {
    if (input.depth.values)
        return with_views(job::DepthArrays{library::depth_of(input.depth, config.depth)}, input, config);
    return with_views(job::DisparityArrays{library::map_of(input.disparity, config.disparity)}, input,
                      config);
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
    job::RunLog log;  // without callbacks between the calls
    std::shared_ptr<job::Relief> relief;
    std::vector<job::OutputFile> written;

    const SurfaceMesh& surface() const { return relief->surface.mesh; }
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
    return floats_of(state_->relief->surface.lattice.positions);
}
int Mesh::lattice_columns() const {
    return state_->relief->surface.lattice.columns;
}
int Mesh::lattice_rows() const {
    return state_->relief->surface.lattice.rows;
}

MapView Mesh::disparity() const {
    const DisparityMap& map = state_->relief->disparity.meshed();
    return {map.values.data(), map.width, map.height};
}

std::string Mesh::report() const {
    const std::lock_guard lock(library_mutex);
    const job::Relief& relief = *state_->relief;
    std::vector<std::filesystem::path> paths;
    for (const job::OutputFile& file : state_->written) paths.emplace_back(file.path);
    std::erase_if(
        paths, [](const auto& path) { return !exporters::find_mesh_format(path); });  // textures and the like
    job::RunReport report{state_->relief};
    job::take_measures(paths, report);
    report.shares = job::shares_of(relief);
    report.outputs = state_->written;
    job::take_figures(state_->log, report);
    return job::report_json(report);
}

std::vector<std::string> Mesh::save(const std::string& path, const Options& options) const {
    const std::lock_guard lock(library_mutex);
    State& state = *state_;
    config::Config& config = state.relief->surface.config;
    // Undoes the changes of this call.
    struct Restore {
        State& state;
        config::Config& changed;
        const config::Config config = changed;
        ~Restore() {
            changed = config;
            library::tell_caller({}, state.log);
        }
    } restore{state, config};
    library::tell_caller(options, state.log);
    library::apply_export_settings(config, options);
    if (library::sets_tolerance(options))
        config = job::with_tolerance(config, state.surface(), state.relief->view(),
                                     state.relief->backend->threads(), state.log);
    for (const std::filesystem::path& file : job::planned_files(path, config.exporting))
        files::check_writable_file(file);
    job::RunRequest request{.outputs = {path}};
    const job::RunReport report = job::write_relief(state.relief, request, state.log);
    std::vector<std::string> files;
    for (const job::OutputFile& file : report.outputs) {
        std::erase_if(state.written, [&](const job::OutputFile& other) { return other.path == file.path; });
        state.written.push_back(file);
        files.push_back(file.path);
    }
    return files;
}

Picture read_picture(const std::string& path) {
    Image image = readers::read_image(path);
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
    const config::Config config = library::config_of(options, {}, {"--disparity"});
    DisparityMap map = readers::read_disparity_map(path, config.input.disparity, config.limits.reading);
    return {map.width, map.height, std::move(map.values)};
}

Disparities compute_disparity(const ImageView& left, const ImageView& right, const Camera& camera,
                              const Options& options) {
    const std::lock_guard lock(library_mutex);
    job::RunRequest request{.config = library::config_of(options, camera)};
    request.config.disparity.working_px = 0;  // the map is one of the given pictures
    request.source = job::PairArrays{{library::image_of(left, "left"), library::image_of(right, "right")}};
    job::RunLog log;
    library::tell_caller(options, log);
    DisparityMap map = job::make_disparities(std::move(request), kept_backends(), log).disparity.map;
    return {map.width, map.height, std::move(map.values)};
}

Mesh mesh_input(const MapInput& input, const Camera& camera, const Options& options) {
    const std::lock_guard lock(library_mutex);
    const bool is_depth = input.depth.values != nullptr;
    if (is_depth && input.disparity.values != nullptr)
        throw Error(ErrorKind::usage, "disparities or depths, not both");
    auto state = std::make_unique<Mesh::State>();
    library::tell_caller(options, state->log);
    job::RunRequest request{.config =
                                library::config_of(options, camera, {is_depth ? "--depth" : "--disparity"})};
    request.source = source_of(input, request.config.input);
    request.outputs = {kLimitedOutput};
    state->relief =
        std::make_shared<job::Relief>(job::make_relief(std::move(request), kept_backends(), state->log));
    library::tell_caller({}, state->log);
    return Mesh(std::move(state));
}

Mesh mesh(const MapView& disparity, const ImageView& color, const Camera& camera, const Options& options) {
    return mesh_input({.disparity = disparity, .color = color}, camera, options);
}

RunSummary run(const FileRequest& files, const Options& options) {
    const std::lock_guard lock(library_mutex);
    job::RunRequest request = library::request_of(files, options);
    if (files.update) {
        job::check_request(request);
        if (job::stamp_request(request) == job::UnitState::current) return {.is_up_to_date = true};
    }
    job::RunLog log;
    library::tell_caller(options, log);
    if (!files.ends_process) return library::summary_of(job::run_job(request, kept_backends(), log));
    job::Backends backends = job::Backends::for_one_run();
    return library::summary_of(job::run_job(request, backends, log));
}

void check_run(const FileRequest& files, const Options& options) {
    job::check_request(library::request_of(files, options));
}

void end_on_interrupt() {
    files::install_interrupt_handling();
}

std::string version() {
    return HEXRELIEF_VERSION;
}

}  // namespace v0
}  // namespace hexrelief
