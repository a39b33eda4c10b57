#include "pipeline/bench/batch/bench_batch.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>

#include "exporters/exporter.h"
#include "pipeline/bench/backends.h"
#include "pipeline/bench/bench_rows.h"
#include "pipeline/bench/maps.h"
#include "pipeline/bench/match/match_scenes.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/steps.h"
#include "pipeline/readers/image_reader.h"

namespace hexrelief::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Scenery {
    std::string name;
    StereoPair pair;
    Calibration camera;
};

struct Crew {
    config::BackendChoice backend;
    int workers, threads;  // threads of each worker
};

struct BatchRow {
    double start_s = 0, seconds = 0;
    Times jobs = {};
    std::uint64_t bytes = 0;  // of one GLB
};

// Runs the steps of run_job() without its files.
std::uint64_t do_job(const Scenery& scene, const config::Config& config, job::Backend& backend,
                     job::RunLog& log) {
    const int threads = backend.threads();
    const stages::FoundRange range = stages::find_range(scene.pair, scene.camera, config.disparity, threads);
    const job::DisparityResult matched = job::disparities_of_pair(
        scene.pair, stages::corrected(scene.pair, range.correction, threads), range.config, backend);
    const DensityMap density = job::density_of(matched.meshed(), config.density, threads, log);
    const job::LeftView view{matched.map,     matched.meshed(), density,     scene.pair.left,
                             scene.pair.left, scene.camera,     scene.camera};
    const job::SurfaceResult result = job::make_surface(view, config, backend, log);
    exporters::Scene written = job::scene_of(view, result, {});
    written.threads = threads;
    return exporters::export_size(written, config.exporting, "job.glb");
}

// One worker: does a first job, which starts everything that is kept, and then jobs as long as
// there are some left.
class Worker {
  public:
    Worker(const Scenery& scene, const config::Config& config, const Crew& crew)
        : scene_(scene), config_(config), backend_(job::pick_backend(crew.backend, crew.threads)) {
        bytes_ = job();
    }
    std::vector<double> work(std::atomic<int>& left) {
        std::vector<double> seconds;
        while (left.fetch_sub(1) > 0) {
            const double begun = now_seconds();
            if (job() != bytes_) throw std::logic_error("two jobs on one pair gave different files");
            seconds.push_back(now_seconds() - begun);
        }
        return seconds;
    }
    std::uint64_t bytes() const { return bytes_; }

  private:
    std::uint64_t job() const {
        job::RunLog log;
        return do_job(scene_, config_, *backend_, log);
    }
    const Scenery& scene_;
    const config::Config& config_;
    job::BackendPointer backend_;
    std::uint64_t bytes_ = 0;
};

// More than one thread, so that start_work() always uses a thread of its own.
constexpr int kOwnThread = 2;

BatchRow measure(const Scenery& scene, const config::Config& config, const Crew& crew, int jobs) {
    BatchRow row;
    const double starting = now_seconds();
    std::vector<std::future<Worker>> starts;
    for (int i = 0; i < crew.workers; ++i)
        starts.push_back(start_work(kOwnThread, [&] { return Worker(scene, config, crew); }));
    std::vector<Worker> workers;
    for (std::future<Worker>& start : starts) workers.push_back(start.get());
    row.start_s = now_seconds() - starting;

    std::atomic<int> left = jobs;
    const double begun = now_seconds();
    std::vector<std::future<std::vector<double>>> working;
    for (Worker& worker : workers)
        working.push_back(start_work(kOwnThread, [&] { return worker.work(left); }));
    for (auto& work : working)
        for (const double seconds : work.get()) row.jobs.runs.push_back(seconds);
    row.seconds = now_seconds() - begun;
    row.bytes = workers.front().bytes();
    for (const Worker& worker : workers)
        if (worker.bytes() != row.bytes) throw std::logic_error("two workers gave different files");
    return row;
}

std::vector<Scenery> load(const BatchOptions& options, const config::Config& config) {
    std::vector<std::string> left_out, names;
    const std::vector<match::ScenePair> found = match::find_scenes(options.data, left_out);
    for (const match::ScenePair& scene : found) names.push_back(scene.name);
    check_names(options.scenes, names, "--scenes");
    std::vector<Scenery> scenes;
    for (const match::ScenePair& scene : found) {
        if (!wanted(options.scenes, scene.name)) continue;
        Scenery loaded{scene.name, {readers::read_image(scene.left), readers::read_image(scene.right)}, {}};
        const job::ViewSize view{loaded.pair.left.width, loaded.pair.left.height};
        loaded.camera = job::resolve_calibration({config.input.calibration, view, view}).calibration;
        scenes.push_back(std::move(loaded));
    }
    if (scenes.empty())
        throw Error(ErrorKind::input, "--data " + options.data.string() +
                                          ": no folder below it holds left.*, right.* and disp.*");
    return scenes;
}

void report(const Scenery& scene, const std::string& backend, const Crew& crew, const BatchRow& row,
            std::ostream& out, Json& rows) {
    const double rate = static_cast<double>(row.jobs.runs.size()) / row.seconds;
    const Image& left = scene.pair.left;
    out << format("%-20s %5dx%-5d %-5s %4d x %-4d %8zu %9.3f %9.1f %10.2f %10.2f %10llu\n",
                  scene.name.c_str(), left.width, left.height, backend.c_str(), crew.workers, crew.threads,
                  row.jobs.runs.size(), row.start_s, rate, 1e3 * row.jobs.median(), 1e3 * row.jobs.most(),
                  static_cast<unsigned long long>(row.bytes))
        << std::flush;
    rows.push_back({{"scene", scene.name},
                    {"width", left.width},
                    {"height", left.height},
                    {"backend", backend},
                    {"workers", crew.workers},
                    {"threads_each", crew.threads},
                    {"jobs", row.jobs.runs.size()},
                    {"start_seconds", row.start_s},
                    {"jobs_per_second", rate},
                    {"job_seconds", {{"median", row.jobs.median()}, {"most", row.jobs.most()}}},
                    {"bytes", row.bytes}});
}

}  // namespace

void run_bench_batch(const BatchOptions& options, std::ostream& out) {
    if (options.jobs < 1) throw Error(ErrorKind::usage, "--jobs: must be at least 1");
    if (options.workers < 0) throw Error(ErrorKind::usage, "--workers: must not be negative");
    config::Config config;
    for (const std::string& setting : options.settings) config::apply_setting(config, setting);
    const std::vector<Scenery> scenes = load(options, config);
    if (!options.json.empty()) files::check_writable_file(options.json);
    const int threads = job::effective_threads(options.threads);
    const int workers = options.workers > 0 ? options.workers : threads;

    Json json;
    json["schema"] = 1;
    json["version"] = HEXRELIEF_VERSION;
    json["threads"] = threads;
    json["settings"] = options.settings;
    json["backends"] = Json::array();
    json["rows"] = Json::array();
    const std::vector<job::BackendPointer> backends = usable_backends(threads);
    for (const job::BackendPointer& backend : backends) {
        out << backend->name() << ": " << backend->device() << '\n';
        json["backends"].push_back({{"name", backend->name()}, {"device", backend->device()}});
    }
    out << "From two images in memory to a GLB in memory; threads " << threads << " in all.\n"
        << format("%-20s %-11s %-5s %-11s %8s %9s %9s %10s %10s %10s\n", "scene", "size", "on", "at a time",
                  "jobs", "start s", "jobs/s", "median ms", "most ms", "bytes");
    for (const Scenery& scene : scenes)
        for (const job::BackendPointer& backend : backends) {
            const config::BackendChoice choice =
                backend->name() == "cuda" ? config::BackendChoice::cuda : config::BackendChoice::cpu;
            const Crew crew{choice, workers, std::max(1, threads / workers)};
            report(scene, backend->name(), crew, measure(scene, config, crew, options.jobs), out,
                   json["rows"]);
        }
    bench::write_json(options.json, json);
}

}  // namespace hexrelief::bench
