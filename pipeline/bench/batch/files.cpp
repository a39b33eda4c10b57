#include "pipeline/bench/batch/files.h"

#include <stdlib.h>
#include <sys/resource.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "pipeline/batch/batch.h"
#include "pipeline/bench/bench_rows.h"
#include "pipeline/bench/match/match_scenes.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

class ScratchFolder {
  public:
    ScratchFolder() {
        std::string name = (fs::temp_directory_path() / "hexrelief-bench-XXXXXX").string();
        if (!mkdtemp(name.data())) throw Error(ErrorKind::output, "cannot make a folder " + name);
        path_ = name;
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    ~ScratchFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

struct Throughput {
    double seconds = 0, cpu_seconds = 0;  // cpu_seconds: of all workers, user and system
};

double children_cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

Throughput measure_workers(const match::ScenePair& scene, const config::Config& config, int jobs,
                           int workers) {
    const ScratchFolder folder;
    std::vector<batch::BatchUnit> units;
    for (int i = 0; i < jobs; ++i) {
        const std::string name = std::to_string(i);
        units.push_back({name, name, {(folder.path() / name).string()}, ""});
    }
    batch::BatchSettings settings;
    settings.workers = settings.threads = workers;
    settings.rules.parse = [&](const std::vector<std::string>& words) {
        job::RunRequest request;
        request.source = job::PairFiles{scene.left, scene.right};
        request.config = config;
        request.outputs = {words[0] + ".glb"};
        request.report = words[0] + ".json";
        return request;
    };
    const double begun = now_seconds(), cpu_begun = children_cpu_seconds();
    const batch::BatchResult result = batch::run_units(units, settings, {});
    const Throughput taken{now_seconds() - begun, children_cpu_seconds() - cpu_begun};
    for (const batch::UnitResult& unit : result.units)
        if (unit.outcome != batch::UnitOutcome::done) throw Error(ErrorKind::input, unit.message);
    return taken;
}

Throughput best(const Throughput& a, const Throughput& b) {
    return {std::min(a.seconds, b.seconds), std::min(a.cpu_seconds, b.cpu_seconds)};
}

Json throughput_json(const Throughput& taken, int jobs) {
    return {{"seconds", taken.seconds},
            {"cpu_seconds", taken.cpu_seconds},
            {"jobs_per_second", jobs / taken.seconds}};
}

}  // namespace

void run_bench_batch_files(const BatchOptions& options, std::ostream& out) {
    if (options.jobs < 1) throw Error(ErrorKind::usage, "--jobs: must be at least 1");
    config::Config config;
    for (const std::string& setting : options.settings) config::apply_setting(config, setting);
    if (!options.json.empty()) files::check_writable_file(options.json);
    const int workers = options.workers > 0 ? options.workers : job::effective_threads(options.threads);
    Json json = {{"schema", 1},          {"version", HEXRELIEF_VERSION}, {"workers", workers},
                 {"jobs", options.jobs}, {"settings", options.settings}, {"rows", Json::array()}};
    out << format("From files to files, one thread each: one after the other, then %d at a time.\n", workers)
        << format("%-20s %8s %10s %10s %8s %12s %12s\n", "scene", "jobs", "one jobs/s", "all jobs/s", "times",
                  "one CPU ms", "all CPU ms");
    std::vector<std::string> left_out;
    for (const match::ScenePair& scene : match::find_scenes(options.data, left_out)) {
        const bool wanted = options.scenes.empty() || std::find(options.scenes.begin(), options.scenes.end(),
                                                                scene.name) != options.scenes.end();
        if (!wanted) continue;
        Throughput one = measure_workers(scene, config, options.jobs, 1),
                   all = measure_workers(scene, config, options.jobs, workers);
        one = best(one, measure_workers(scene, config, options.jobs, 1));
        all = best(all, measure_workers(scene, config, options.jobs, workers));
        const double times = one.seconds / all.seconds, each_ms = 1e3 / options.jobs;
        out << format("%-20s %8d %10.2f %10.2f %8.2f %12.1f %12.1f\n", scene.name.c_str(), options.jobs,
                      options.jobs / one.seconds, options.jobs / all.seconds, times,
                      one.cpu_seconds * each_ms, all.cpu_seconds * each_ms)
            << std::flush;
        json["rows"].push_back({{"scene", scene.name},
                                {"one", throughput_json(one, options.jobs)},
                                {"all", throughput_json(all, options.jobs)},
                                {"times", times}});
    }
    if (json["rows"].empty()) throw Error(ErrorKind::input, "--scenes: none of these is in --data");
    write_json(options.json, json);
}

}  // namespace hexrelief::bench
