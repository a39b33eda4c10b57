#include "samples/scene_files.h"

#include <cstdio>

#include "exporters/core/file_transaction.h"
#include "exporters/images/image_writer.h"
#include "samples/sample_pair.h"

namespace hexrelief::samples {
namespace {

// Middlebury's form: the baseline in millimetres, the principal point counted from the centre of the first
// pixel.
std::string middlebury_calibration(const SampleScene& scene) {
    const Calibration& c = scene.calibration;
    char camera[128], text[512];
    std::snprintf(camera, sizeof camera, "[%g 0 %g; 0 %g %g; 0 0 1]", c.focal_px, c.cx - 0.5, c.focal_px,
                  c.cy - 0.5);
    std::snprintf(text, sizeof text,
                  "cam0=%s\ncam1=%s\ndoffs=%g\nbaseline=%g\nwidth=%d\nheight=%d\nndisp=48\n", camera, camera,
                  c.doffs_px, 1000 * c.baseline_m, c.width, c.height);
    return text;
}

}  // namespace

std::vector<SampleFile> sample_files() {
    const SampleScene scene = render_sample_scene();
    const DisparityMap& map = scene.disparity;
    const std::string calibration = middlebury_calibration(scene);
    return {{"left.png", exporters::encode_png(scene.pair.left)},
            {"right.png", exporters::encode_png(scene.pair.right)},
            {"disparity.pfm", exporters::encode_pfm(map.width, map.height, map.values)},
            {"calib.txt", {calibration.begin(), calibration.end()}}};
}

std::vector<SampleFile> photograph_files() {
    const StereoPair pair = render_photographs();
    return {{"left.png", exporters::encode_png(pair.left)}, {"right.png", exporters::encode_png(pair.right)}};
}

void write_sample_files(const std::vector<SampleFile>& files, const std::filesystem::path& folder) {
    exporters::FileTransaction transaction;
    for (const SampleFile& file : files) transaction.write(folder / file.name, file.bytes);
    transaction.commit();
}

}  // namespace hexrelief::samples
