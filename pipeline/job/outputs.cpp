#include "pipeline/job/outputs.h"

#include <cstdio>

#include "exporters/exporter.h"
#include "exporters/images/image_writer.h"
#include "pipeline/job/report.h"
#include "pipeline/job/tolerance.h"
#include "pipeline/pictures/stage_pictures.h"

namespace hexrelief {

namespace fs = std::filesystem;

Scene scene_of(const LeftView& view, const SurfaceResult& result, const std::vector<DetailLevel>& coarser) {
    Scene scene{&result.surface.mesh,
                view.texture.empty() ? nullptr : &view.texture,
                std::string("hexrelief ") + HEXRELIEF_VERSION,
                extras_json(view, result),
                &view.calibration,
                {}};
    scene.image_width = view.disparity.width;
    scene.image_height = view.disparity.height;
    for (const DetailLevel& level : coarser) scene.coarser.push_back(&level.mesh);
    return scene;
}

SurfaceMeasures measure_written(const LeftView& view, const SurfaceResult& result,
                                const std::vector<fs::path>& outputs, const RunContext& run) {
    const SurfaceMesh& surface = result.surface.mesh;
    return measure_surface(surface, as_written(scene_of(view, result, {}), result.config.exporting, outputs),
                           view, run);
}

std::vector<OutputFile> export_all(const Scene& scene, const ExportConfig& config,
                                   const std::vector<fs::path>& paths, OutputSet& files, const RunLog& log) {
    std::vector<OutputFile> outputs;
    double done = 0;
    for (const fs::path& name : paths) {
        files.place(name);
        const std::size_t before = files.written().size();
        export_scene(scene, config, name, files.files());
        for (std::size_t i = before; i < files.written().size(); ++i) {
            const WrittenFile& file = files.written()[i];
            const std::string extension = file.path.extension().string();
            outputs.push_back(
                {file.path.string(),
                 i == before ? export_format(name).name() : extension.substr(!extension.empty()), file.bytes,
                 file.sha256});
        }
        log.progress(++done / static_cast<double>(paths.size()));
    }
    return outputs;
}

void save_stages(const LeftView& view, const SurfaceResult& result, const fs::path& folder, OutputSet& files,
                 const RunContext& run) {
    files.make_folder(folder);
    const StageResults results{&view.meshed,
                               &view.density,
                               &result.lattice.mesh,
                               &result.surface.mesh,
                               view.color.empty() ? nullptr : &view.color,
                               result.config.mesh.seed,
                               run.threads};
    double done = 0;
    for (const fs::path& name : stage_file_names()) {
        files.files().write(folder / name, encode_stage_file(results, name));
        run.log.progress(++done / static_cast<double>(stage_file_names().size()));
    }
}

void save_rectified(const RunInput& input, const fs::path& folder, OutputSet& files) {
    files.make_folder(folder);
    const std::vector<fs::path>& names = rectified_file_names();
    files.files().write(folder / names[0], encode_png(input.pair.left));
    files.files().write(folder / names[1], encode_png(input.pair.right));
    const Calibration& camera = input.calibration;
    std::string text = "# The camera of " + names[0].string() + " and " + names[1].string() + ".\n";
    const auto line = [&](const char* key, double value) {
        char number[64];
        std::snprintf(number, sizeof number, "%s: %.17g\n", key, value);
        text += number;
    };
    line("focal_px", camera.focal_px);
    line("baseline_m", camera.baseline_m);
    line("cx", camera.cx);
    line("cy", camera.cy);
    line("doffs_px", camera.doffs_px);
    line("width", camera.width);
    line("height", camera.height);
    write_text_file(text, folder / names[2], files);
}

void write_text_file(const std::string& text, const fs::path& name, OutputSet& files) {
    files.place(name);
    files.files().write(name, text);
}

}  // namespace hexrelief
