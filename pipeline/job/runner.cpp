#include "pipeline/job/runner.h"

#include <future>
#include <string>
#include <utility>

#include "pipeline/data/background.h"
#include "pipeline/job/input_checks.h"
#include "pipeline/job/maps/mask_input.h"
#include "pipeline/job/meet_budget.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/page_content.h"
#include "pipeline/job/run_files.h"
#include "pipeline/job/steps.h"
#include "pipeline/job/tolerance.h"

namespace hexrelief::job {

namespace {

// A device's driver starts in a thread of its own whatever the job's threads: it mostly waits.
constexpr int kWithDriver = 2;

RunSize size_of(const RunInput& input, int threads, int jobs) {
    if (input.is_pair()) return {input.pair.left.width, input.pair.left.height, true, threads, jobs};
    return {input.map.width, input.map.height, false, threads, jobs};
}

std::string reason_for(const Backend& backend, const BackendDecision& decision) {
    const bool missing = decision.choice == config::BackendChoice::automatic && backend.name == "cpu";
    return decision.reason + (missing ? ", but none is usable" : "");
}

// Input, backend and threads of the relief, and the range to search where the input is a pair. A device that
// is asked for starts while the files are read; one that auto takes, when their size is known, while the
// range is chosen.
ChosenRange prepare(const InputSource& read, const RunRequest& request, const BackendPicker& pick,
                    RunLog& log, Relief& relief) {
    const config::Config& config = request.config;
    const int threads = relief.threads = effective_threads(config.run.threads);
    if (threads < config.run.threads)
        log.decide("threads: " + std::to_string(threads) + " in place of " +
                   std::to_string(config.run.threads) + ": more would wait for each other");
    const auto start = [&](config::BackendChoice choice) {
        return start_work(kWithDriver, [&, choice] { return pick(choice, threads, config.mesh.method); });
    };
    std::future<Backend> starting;
    if (config.run.backend != config::BackendChoice::automatic) starting = start(config.run.backend);
    const RunInput& input = relief.input = log.stage("input", [&] { return read(threads, log); });
    const BackendDecision decision = choose_backend(size_of(input, threads, request.jobs), config);
    if (!starting.valid()) starting = start(decision.choice);
    ChosenRange range{{config.disparity, {}, {}}};
    if (input.is_pair())
        range = log.stage("range", [&] {
            return choose_range(input.pair, input.calibration, config.disparity, threads, log);
        });
    log.stage("checks", [&] { check_input(request, input, range, threads, log); });
    relief.backend = log.stage("device", [&] { return starting.get(); });
    relief.backend_reason = reason_for(relief.backend, decision);
    if (!relief.backend.missed.empty()) log.warn(going_on_without(relief.backend.missed));
    if (config.run.backend == config::BackendChoice::automatic && relief.backend.name != "cpu")
        relief.backend = with_replacement(
            relief.backend, pick_backend(config::BackendChoice::cpu, threads, config.mesh.method),
            [&log](const std::string& warning) { log.warn(warning); });
    log.decide("backend: " + relief.backend.name + ", " + relief.backend_reason);
    return range;
}

// What the report calls the backend, where the CPU had to take over.
void tell_of_replacement(Relief& relief) {
    if (!relief.backend.is_replaced || !*relief.backend.is_replaced) return;
    const Backend cpu = pick_backend(config::BackendChoice::cpu, relief.threads);
    relief.backend.name = cpu.name;
    relief.backend.device = cpu.device;
    relief.backend_reason += ", but the device failed";
}

}  // namespace

LeftView Relief::view() const {
    return {disparity.map, disparity.meshed(), density, input.pair.left, input.texture(), input.calibration};
}

Relief make_disparities(const InputSource& read, const RunRequest& request, const BackendPicker& pick,
                        RunLog& log) {
    const config::Config& config = request.config;
    for (const std::string& warning : config.warnings) log.warn(warning);
    if (const std::string told = levels_inside_warning(request); !told.empty()) log.warn(told);
    for (const std::string& decision : config.decisions) log.decide(decision);
    Relief relief;
    const ChosenRange range = prepare(read, request, pick, log, relief);
    RunInput& input = relief.input;
    const RunContext run{relief.backend, relief.threads, log};
    if (!input.is_pair())
        input.map = densify_input(std::move(input.map), input.pair.left, input.mask, config, run);
    relief.disparity = log.stage("disparity", [&] {
        if (!input.is_pair()) return smooth_input(std::move(input.map), config, run);
        DisparityResult matched = match_input(input.pair, range, run);
        hide(matched.map, input.mask);
        return matched;
    });
    return relief;
}

Relief make_relief(const InputSource& read, const RunRequest& request, const BackendPicker& pick,
                   RunLog& log) {
    const config::Config& config = request.config;
    Relief relief = make_disparities(read, request, pick, log);
    count_from_infinity(relief.disparity, relief.input.calibration, log);
    const RunContext run{relief.backend, relief.threads, log};
    relief.density = log.stage("density", [&] {
        return density_of(relief.disparity.meshed(), config.density, relief.threads, log);
    });
    const LeftView view = relief.view();
    relief.result = has_budget(config.budget) ? meet_budget(view, config, request.outputs, run)
                                              : make_surface(view, config, run);
    warn_of_inversions(relief.result.quality, log);
    tell_of_replacement(relief);
    return relief;
}

RunReport write_relief(const Relief& relief, const RunRequest& request, RunLog& log) {
    const SurfaceResult& result = relief.result;
    const LeftView view = relief.view();
    const RunContext run{relief.backend, relief.threads, log};
    SurfaceMeasures measures;
    const bool with_page = has_page(request.outputs);
    if (!request.report.empty() || with_page)
        measures = log.stage("measures", [&] { return measure_written(view, result, request.outputs, run); });
    std::vector<DetailLevel> coarser;
    if (result.config.exporting.lod > 1)
        coarser = log.stage("levels", [&] { return coarser_levels(view, result.config, run); });

    files::OutputSet files;
    exporters::Scene scene = scene_of(view, result, coarser);
    scene.threads = relief.threads;
    exporters::PageContent page;
    if (with_page)
        page = log.stage("page", [&] { return page_content(view, result, measures, relief.threads); });
    scene.page = with_page ? &page : nullptr;
    auto shares = start_work(relief.threads, [&] { return shares_of(view, result); });
    const std::vector<OutputFile> outputs = log.stage(
        "export", [&] { return export_all(scene, result.config.exporting, request.outputs, files, log); });
    if (!request.stages_folder.empty())
        log.stage("pictures", [&] {
            save_stages(view, result, request.stages_folder, files, run);
            if (relief.input.is_rectified) save_rectified(relief.input, request.stages_folder, files);
        });
    RunReport report = assemble_report({relief.backend_reason, relief.input, relief.disparity, view, result,
                                        measures, coarser, outputs, shares.get()},
                                       run);
    report.stamp = request.stamp;
    if (!request.depfile.empty()) write_text_file(depfile_rule(request), request.depfile, files);
    if (!request.report.empty()) write_text_file(report_json(report), request.report, files);
    files.commit();
    return report;
}

RunReport run_job(const RunRequest& request, const RunObserver& observer, const BackendPicker& pick) {
    check_request(request);
    RunLog log(observer);
    const auto read = [&](int threads, RunLog& told) { return read_input(request, threads, told); };
    const Relief relief = make_relief(read, request, pick, log);
    std::future<void> giving_back;
    const bool needed = request.config.exporting.lod > 1;  // coarser levels are solved when files are written
    if (relief.backend.give_back && !needed) giving_back = start_work(kWithDriver, relief.backend.give_back);
    return write_relief(relief, request, log);
}

}  // namespace hexrelief::job
