#include "pipeline/job/runner.h"

#include "pipeline/job/input.h"
#include "pipeline/job/meet_budget.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/steps.h"
#include "pipeline/job/tolerance.h"

namespace hexrelief {

RunReport run_job(const RunRequest& request, const RunObserver& observer, const BackendPicker& pick) {
    check_request(request);
    RunLog log(observer);
    const Config& config = request.config;
    for (const std::string& warning : config.warnings) log.warn(warning);
    for (const std::string& decision : config.decisions) log.decide(decision);
    const int threads = effective_threads(config.run.threads);
    const Backend backend =
        log.stage("device", [&] { return pick(config.run.backend, threads, config.mesh.method); });
    const RunContext run{backend, threads, log};

    RunInput input = log.stage("input", [&] { return read_input(request, log); });
    const DisparityResult disparity = log.stage("disparity", [&] {
        return input.is_pair() ? match_input(input.pair, config.disparity, run)
                               : smooth_input(std::move(input.map), config, run);
    });
    const DensityMap density =
        log.stage("density", [&] { return density_of(disparity.meshed(), config.density, log); });
    const LeftView view{disparity.map, disparity.meshed(), density, input.pair.left, input.calibration};
    const SurfaceResult result = has_budget(config.budget) ? meet_budget(view, config, request.outputs, run)
                                                           : make_surface(view, config, run);
    warn_of_inversions(result.quality, log);
    SurfaceMeasures measures;
    if (!request.report.empty())
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
    const std::vector<OutputFile> outputs = log.stage(
        "export", [&] { return export_all(scene, result.config.exporting, request.outputs, files, log); });
    if (!request.stages_folder.empty())
        log.stage("pictures", [&] { save_stages(view, result, request.stages_folder, files, run); });
    const RunReport report =
        assemble_report({input.files, disparity, view, result, measures, coarser, outputs}, run);
    if (!request.report.empty()) write_text_file(report_json(report), request.report, files);
    files.commit();
    return report;
}

}  // namespace hexrelief
