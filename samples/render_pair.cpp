// render_pair FOLDER: writes left.png, right.png, disparity.pfm and calib.txt of the synthetic sample scene.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "exporters/core/file_transaction.h"
#include "exporters/images/image_writer.h"
#include "samples/scene.h"

namespace {

// Middlebury's form: the baseline in millimetres, the principal point counted from the centre of the first
// pixel.
std::string middlebury_calibration(const hexrelief::SampleScene& scene) {
    const hexrelief::Calibration& c = scene.calibration;
    char camera[128], text[512];
    std::snprintf(camera, sizeof camera, "[%g 0 %g; 0 %g %g; 0 0 1]", c.focal_px, c.cx - 0.5, c.focal_px,
                  c.cy - 0.5);
    std::snprintf(text, sizeof text,
                  "cam0=%s\ncam1=%s\ndoffs=%g\nbaseline=%g\nwidth=%d\nheight=%d\nndisp=48\n", camera, camera,
                  c.doffs_px, 1000 * c.baseline_m, c.width, c.height);
    return text;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: render_pair FOLDER\n");
        return 2;
    }
    try {
        const std::filesystem::path folder = argv[1];
        const hexrelief::SampleScene scene = hexrelief::render_sample_scene();
        hexrelief::write_png(folder / "left.png", scene.pair.left);
        hexrelief::write_png(folder / "right.png", scene.pair.right);
        hexrelief::write_pfm(folder / "disparity.pfm", scene.disparity.width, scene.disparity.height,
                             scene.disparity.values);
        hexrelief::FileTransaction calibration;
        calibration.write(folder / "calib.txt", middlebury_calibration(scene));
        calibration.commit();
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "render_pair: %s\n", error.what());
        return 4;
    }
}
