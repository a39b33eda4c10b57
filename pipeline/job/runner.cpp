#include "pipeline/job/runner.h"

#include "exporters/core/file_transaction.h"
#include "pipeline/job/job.h"
#include "pipeline/job/output_set.h"
#include "pipeline/job/run_files.h"
#include "pipeline/job/sha256.h"
#include "pipeline/pictures/stage_pictures.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

void export_all(Job& job, OutputSet& outputs) {
    const Scene scene = scene_of(job);
    double done = 0;
    for (const fs::path& path : job.request.outputs) {
        const ExportConfig& config = job.request.config.exporting;
        const auto written =
            outputs.add(planned_files(path, config), [&] { return export_scene(scene, config, path); });
        for (const fs::path& file : written) {
            const std::string extension = file.extension().string();
            job.report.outputs.push_back(
                {file.string(), file == path ? export_format(path) : extension.substr(!extension.empty()),
                 fs::file_size(file), sha256_of_file(file)});
        }
        done += 1;
        if (job.observer.stage_progresses)
            job.observer.stage_progresses(done / static_cast<double>(job.request.outputs.size()));
    }
}

void save_stages(Job& job, OutputSet& outputs) {
    const fs::path& folder = job.request.stages_folder;
    outputs.make_folder(folder);
    const StageResults results{&job.map,
                               &job.density,
                               &job.solved.mesh,
                               &job.surface,
                               job.texture.empty() ? nullptr : &job.texture,
                               job.request.config.mesh.seed,
                               job.report.threads};
    double done = 0;
    for (const fs::path& name : stage_file_names()) {
        outputs.add({folder / name}, [&] {
            write_stage_file(results, folder, name);
            return std::vector<fs::path>{folder / name};
        });
        done += 1;
        if (job.observer.stage_progresses)
            job.observer.stage_progresses(done / static_cast<double>(stage_file_names().size()));
    }
}

void write_report(const Job& job, OutputSet& outputs) {
    const fs::path& path = job.request.report;
    outputs.add({path}, [&] {
        FileTransaction files;
        files.write(path, report_json(job.report));
        files.commit();
        return std::vector<fs::path>{path};
    });
}

}  // namespace

RunReport run_job(const RunRequest& request, const RunObserver& observer) {
    check_request(request);
    const int threads = effective_threads(request.config.run.threads);
    Job job{request, observer, {}, {}, {}, {}, {}, {}, {}, {}};
    job.stage("device", [&] {
        const MeshConfig& mesh = request.config.mesh;
        job.backend = pick_backend(request.config.run.backend, threads, mesh.method);
    });
    job.report.backend = job.backend.name;
    job.report.device = job.backend.device;
    job.report.threads = threads;
    job.report.config = request.config;
    obtain_map(job);
    job.stage("density", [&] { compute_densities(job); });
    if (has_budget(request.config.budget))
        meet_budget(job);
    else
        make_surface(job);
    warn_of_inversions(job);
    if (!request.report.empty()) job.stage("relief", [&] { measure_surface(job); });
    if (request.config.exporting.lod > 1) job.stage("levels", [&] { make_coarser_levels(job); });
    OutputSet outputs;
    job.stage("export", [&] { export_all(job, outputs); });
    if (!request.stages_folder.empty()) job.stage("pictures", [&] { save_stages(job, outputs); });
    if (!request.report.empty()) write_report(job, outputs);
    outputs.commit();
    return std::move(job.report);
}

}  // namespace hexrelief
