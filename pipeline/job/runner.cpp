#include "pipeline/job/runner.h"

#include <future>
#include <string>
#include <utility>

#include "pipeline/data/background.h"
#include "pipeline/job/input.h"
#include "pipeline/job/input_checks.h"
#include "pipeline/job/maps/mask_input.h"
#include "pipeline/job/meet_budget.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/page_content.h"
#include "pipeline/job/steps.h"
#include "pipeline/job/tolerance.h"

namespace hexrelief {

namespace {

// A device's driver starts in a thread of its own whatever the job's threads: it mostly waits.
constexpr int kWithDriver = 2;

RunSize size_of(const RunInput& input, int threads, int jobs) {
    if (input.is_pair()) return {input.pair.left.width, input.pair.left.height, true, threads, jobs};
    return {input.map.width, input.map.height, false, threads, jobs};
}

std::string reason_for(const Backend& backend, const BackendDecision& decision) {
    const bool missing = decision.choice == BackendChoice::automatic && backend.name == "cpu";
    return decision.reason + (missing ? ", but none is usable" : "");
}

struct Preparation {
    RunInput input;
    DisparityConfig ranged;  // with the range to search, where the input is a pair
    Backend backend;
    std::string backend_reason;
};

// A device that is asked for starts while the files are read; one that auto takes, when their size is known,
// while the range is chosen.
Preparation prepare(const RunRequest& request, int threads, const BackendPicker& pick, RunLog& log) {
    const Config& config = request.config;
    const auto start = [&](BackendChoice choice) {
        return start_work(kWithDriver, [&, choice] { return pick(choice, threads, config.mesh.method); });
    };
    std::future<Backend> starting;
    if (config.run.backend != BackendChoice::automatic) starting = start(config.run.backend);
    Preparation done;
    done.input = log.stage("input", [&] { return read_input(request, threads, log); });
    const BackendDecision decision = choose_backend(size_of(done.input, threads, request.jobs), config);
    if (!starting.valid()) starting = start(decision.choice);
    ChosenRange range{config.disparity, {}};
    if (done.input.is_pair())
        range = log.stage("range", [&] {
            return choose_range(done.input.pair, done.input.calibration, config.disparity, threads, log);
        });
    log.stage("checks", [&] { check_input(request, done.input, range, threads, log); });
    done.ranged = range.config;
    done.backend = log.stage("device", [&] { return starting.get(); });
    done.backend_reason = reason_for(done.backend, decision);
    log.decide("backend: " + done.backend.name + ", " + done.backend_reason);
    return done;
}

}  // namespace

RunReport run_job(const RunRequest& request, const RunObserver& observer, const BackendPicker& pick) {
    check_request(request);
    RunLog log(observer);
    const Config& config = request.config;
    for (const std::string& warning : config.warnings) log.warn(warning);
    for (const std::string& decision : config.decisions) log.decide(decision);
    const int threads = effective_threads(config.run.threads);
    auto [input, ranged, backend, backend_reason] = prepare(request, threads, pick, log);
    const RunContext run{backend, threads, log};
    if (!input.is_pair())
        input.map = densify_input(std::move(input.map), input.pair.left, input.mask, config, run);

    const DisparityResult disparity = log.stage("disparity", [&] {
        if (!input.is_pair()) return smooth_input(std::move(input.map), config, run);
        DisparityResult matched = match_input(input.pair, ranged, run);
        hide(matched.map, input.mask);
        return matched;
    });
    const DensityMap density =
        log.stage("density", [&] { return density_of(disparity.meshed(), config.density, log); });
    const LeftView view{disparity.map,   disparity.meshed(), density,
                        input.pair.left, input.texture(),    input.calibration};
    const SurfaceResult result = has_budget(config.budget) ? meet_budget(view, config, request.outputs, run)
                                                           : make_surface(view, config, run);
    warn_of_inversions(result.quality, log);
    SurfaceMeasures measures;
    const bool with_page = has_page(request.outputs);
    if (!request.report.empty() || with_page)
        measures = log.stage("measures", [&] {
            const SurfaceMesh& surface = result.surface.mesh;
            return measure_surface(
                surface, as_written(surface, input.calibration, result.config.exporting, request.outputs),
                view, run);
        });
    std::vector<DetailLevel> coarser;
    if (config.exporting.lod > 1)
        coarser = log.stage("levels", [&] { return coarser_levels(view, result.config, run); });

    OutputSet files;
    Scene scene = scene_of(view, result, coarser);
    scene.threads = threads;
    PageContent page;
    if (with_page) page = log.stage("page", [&] { return page_content(view, result, measures, threads); });
    scene.page = with_page ? &page : nullptr;
    const std::vector<OutputFile> outputs = log.stage(
        "export", [&] { return export_all(scene, result.config.exporting, request.outputs, files, log); });
    if (!request.stages_folder.empty())
        log.stage("pictures", [&] {
            save_stages(view, result, request.stages_folder, files, run);
            if (input.is_rectified) save_rectified(input, request.stages_folder, files);
        });
    const RunReport report = assemble_report(
        {backend_reason, input.files, disparity, view, result, measures, coarser, outputs}, run);
    if (!request.report.empty()) write_text_file(report_json(report), request.report, files);
    files.commit();
    return report;
}

}  // namespace hexrelief
