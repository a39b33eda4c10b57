// Whole jobs, with a backend of the test's own.
#include "pipeline/job/runner.h"

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "exporters/images/image_writer.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/job/disparities.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/job/tested_backends.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

using test::ClockedBackend;
using test::FailingBackend;
using test::Fails;

RunRequest sample_request(const test::TemporaryFolder& folder) {
    return {.source = DisparityFiles{test::sample("disparity.pfm")},
            .outputs = {folder / "a.glb"},
            .config = {.input = {.calibration = {.file = test::sample("calib.txt")}},
                       .mesh = {.spacing_px = 12}}};
}

TEST(Runner, DeviceTimeIsThatOfTheFinestLevel) {
    const test::TemporaryFolder folder;
    RunRequest request = sample_request(folder);
    request.config.exporting.lod = 3;
    Backends backends(std::make_shared<ClockedBackend>());
    RunLog log;
    const RunReport report = run_job(request, backends, log);
    ASSERT_EQ(report.coarser.size(), 2u);
    EXPECT_EQ(report.relief->surface.device.surface_s, 1);
    const auto json = nlohmann::json::parse(report_json(report));
    EXPECT_EQ(json["mesh"]["device_surface_seconds"], 1);
}

// A job on a device that fails at `when`.
RunReport run_failing(const RunRequest& request, RunLog& log, Fails when,
                      ErrorKind kind = ErrorKind::device) {
    Backends backends(std::make_shared<FailingBackend>(when, kind));
    return run_job(request, backends, log);
}

RunRequest pair_request(const test::TemporaryFolder& folder) {
    RunRequest request = sample_request(folder);
    request.source = PairFiles{test::sample("left.png"), test::sample("right.png")};
    request.jobs = 1000;  // so many that auto takes a device
    return request;
}

TEST(Runner, TheReportNamesTheMatcher) {
    const test::TemporaryFolder folder;
    for (const char* const method : {"sgm", "sgbm"}) {
        RunRequest request = pair_request(folder);
        config::apply_setting(request.config, std::string("disparity.method=") + method);
        request.config.run.backend = config::BackendChoice::cpu;
        const auto json = nlohmann::json::parse(report_json(run_job(request)));
        EXPECT_EQ(json["disparity"]["method"], method);
    }
}

TEST(Runner, UnderAutoTheCpuGoesOnForADeviceThatFails) {
    const test::TemporaryFolder folder;
    RunRequest request = pair_request(folder);
    run_job(request);
    const std::string expected = test::read_text(folder / "a.glb");
    for (const Fails when : {Fails::matching, Fails::solving, Fails::cutting}) {
        std::vector<std::string> told;
        RunLog log;
        log.warns = [&](const std::string& warning) {
            if (warning.find("backend") != std::string::npos) told.push_back(warning);
        };
        request.config.exporting.lod = 1;
        const RunReport report = run_failing(request, log, when);
        EXPECT_EQ(told, std::vector<std::string>{
                            "backend cuda: training: unspecified launch failure; the CPU goes on"});
        const auto json = nlohmann::json::parse(report_json(report));
        EXPECT_EQ(json["backend"], "cpu");
        EXPECT_NE(json["device"], "a test's");
        EXPECT_CONTAINS(json["backend_reason"].get<std::string>(), "but the device failed");
        EXPECT_EQ(test::read_text(folder / "a.glb"), expected);
    }
    RunLog log;
    EXPECT_THROW(run_failing(request, log, Fails::cutting, ErrorKind::input), Error)
        << "other errors are the run's own";
}

TEST(Runner, ADeviceThatDoesNotStartIsTold) {
    const test::TemporaryFolder folder;
    std::vector<std::string> told;
    RunLog log;
    log.warns = [&](const std::string& warning) { told.push_back(warning); };
    const BackendPointer cpu = pick_backend(config::BackendChoice::cpu, 1);
    cpu->missed = "backend cuda: too little device memory";
    Backends backends(cpu);
    run_job(pair_request(folder), backends, log);
    EXPECT_EQ(std::count(told.begin(), told.end(), "backend cuda: too little device memory; the CPU goes on"),
              1);
}

TEST(Runner, ADeviceThatWasAskedForAndFailsIsAnError) {
    const test::TemporaryFolder folder;
    RunRequest request = pair_request(folder);
    request.config.run.backend = config::BackendChoice::cuda;
    for (const Fails when : {Fails::matching, Fails::solving, Fails::cutting}) {
        RunLog log;
        test::error_of([&] { run_failing(request, log, when); }, ErrorKind::device);
        EXPECT_FALSE(std::filesystem::exists(folder / "a.glb"));
    }
}

TEST(Runner, TheCalibrationSaysTheRange) {
    const StereoPair pair{readers::read_image(test::sample("left.png")),
                          readers::read_image(test::sample("right.png"))};
    Calibration calibration = readers::read_calibration_file(test::sample("calib.txt")).calibration;
    ASSERT_EQ(calibration.ndisp_px, 48);
    std::string said;
    const auto searched = [&](int min_px, int count_px) {
        stages::DisparityConfig config{.min_disparity_px = min_px, .num_disparities_px = count_px};
        const stages::FoundRange range = stages::find_range(pair, calibration, config, 1);
        said = range_text(range.config, range.origin);
        return range.config.num_disparities_px;
    };
    EXPECT_EQ(searched(0, 0), 48);
    EXPECT_EQ(said, "disparity: 48 px searched from 0 px on, by the calibration's ndisp");
    EXPECT_EQ(searched(16, 0), 32);
    EXPECT_EQ(searched(0, 64), 64);
    calibration.ndisp_px = 5000;
    EXPECT_EQ(searched(0, 0), 320) << "the width";
    calibration.ndisp_px = 8;
    EXPECT_GT(searched(16, 0), 0) << "the calibration's range is empty";
    EXPECT_EQ(said.substr(said.rfind(',')), ", chosen from the pair");
}

TEST(Runner, StagesAreToldInOrderAndTimed) {
    const test::TemporaryFolder folder;
    RunRequest request = sample_request(folder);
    request.config.exporting.lod = 2;
    request.config.exporting.tolerance_share = 1;
    request.report = folder / "r.json";
    request.stages_folder = folder / "stages";
    std::vector<std::string> begun, ended, timed;
    RunLog log;
    log.stage_begins = [&](const std::string& stage) { begun.push_back(stage); };
    log.stage_ends = [&](const std::string& stage, double) { ended.push_back(stage); };
    Backends backends;
    const RunReport report = run_job(request, backends, log);
    for (const auto& [stage, seconds] : report.stage_seconds) timed.push_back(stage);
    EXPECT_EQ(begun, (std::vector<std::string>{"input", "checks", "device", "disparity", "density", "mesh",
                                               "surface", "quality", "tolerance", "levels", "export",
                                               "measures", "pictures"}));
    EXPECT_EQ(ended, begun);
    EXPECT_EQ(timed, begun);
}

// Colours of a picture of twice the map's size; its camera, which has the picture's size, is scaled to the
// map.
TEST(Runner, ThePictureMayHaveAnotherSizeThanTheMap) {
    const test::TemporaryFolder folder;
    std::string map = "Pf\n32 24\n-1\n", picture = "P6\n64 48\n255\n";
    for (int i = 0; i < 32 * 24; ++i) {
        const float disparity = 4 + 0.05f * static_cast<float>(i % 32);
        map.append(reinterpret_cast<const char*>(&disparity), sizeof disparity);
    }
    for (int i = 0; i < 64 * 48 * 3; ++i) picture += static_cast<char>(i * 7);
    test::write_text(folder / "d.pfm", map);
    test::write_text(folder / "c.ppm", picture);
    test::write_text(folder / "camera",
                     "{focal_px: 80, baseline_m: 0.1, cx: 31, cy: 24, width: 64, height: 48}");
    const RunRequest request{
        .source = DisparityFiles{folder / "d.pfm", folder / "c.ppm"},
        .outputs = {folder / "a.obj"},
        .config = {.input = {.calibration = {.file = folder / "camera"}},
                   .mesh = {.spacing_px = 4},
                   .exporting = {.texture = exporters::TextureFormat::png, .texture_crop = false}}};
    const RunReport report = run_job(request);
    EXPECT_EQ(report.relief->disparity.map.width, 32);
    EXPECT_EQ(report.relief->input.calibration.focal_px, 40);
    EXPECT_EQ(report.relief->input.calibration.cx, 15.5);
    EXPECT_EQ(readers::read_image(folder / "a_texture.png").width, 64);
    test::write_text(folder / "c.ppm", "P6\n64 52\n255\n" + std::string(64 * 52 * 3, 'x'));
    EXPECT_THROW(run_job(request), Error);
}

// A flat drawing is smaller as PNG than as JPEG.
TEST(Runner, TheTextureIsThePicturesOwnPngIfThatIsSmaller) {
    const test::TemporaryFolder folder;
    RunRequest request = sample_request(folder);
    exporters::write_png(folder / "c.png", {320, 240, 3, std::vector<std::uint8_t>(320 * 240 * 3, 100)});
    request.source = DisparityFiles{test::sample("disparity.pfm"), folder / "c.png"};
    request.outputs = {folder / "a.obj"};
    request.report = folder / "a.json";
    const RunReport report = run_job(request);
    EXPECT_EQ(test::read_text(folder / "a_texture.png"), test::read_text(folder / "c.png"));
    EXPECT_EQ(report.outputs.back().path, folder / "a_texture.png");
    EXPECT_FALSE(std::filesystem::exists(folder / "a_texture.jpg"));
}

// The samples' cameras stand side by side already: rectifying them scales a little, and depths stay.
TEST(Runner, APairIsRectifiedByItsCalibration) {
    const test::TemporaryFolder folder;
    const auto matrix = [](const char* name, int rows, int columns, const std::string& data) {
        return std::string(name) + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
               "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + data + " ]\n";
    };
    const std::string k = "320., 0., 159.5, 0., 320., 119.5, 0., 0., 1.", d = "0.01, 0., 0., 0., 0.";
    test::write_text(folder / "pair.yml", "%YAML:1.0\n---\n" + matrix("K1", 3, 3, k) + matrix("D1", 1, 5, d) +
                                              matrix("K2", 3, 3, k) + matrix("D2", 1, 5, d) +
                                              matrix("R", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") +
                                              matrix("T", 3, 1, "-0.16, 0., 0."));
    RunRequest request = pair_request(folder);
    request.config.input.calibration.file = folder / "pair.yml";
    request.stages_folder = folder / "stages";
    const RunReport report = run_job(request);
    const Relief& rectified = *report.relief;
    EXPECT_NEAR(rectified.input.calibration.baseline_m, 0.16, 1e-9);
    EXPECT_NEAR(rectified.input.calibration.focal_px, 320, 16);
    EXPECT_NEAR(rectified.surface.nearest(), 1.28, 0.1);

    // The saved pair and camera give the same again.
    request.source = PairFiles{folder / "stages/left_rectified.png", folder / "stages/right_rectified.png"};
    request.config.input.calibration.file = folder / "stages/calib.txt";
    request.outputs = {folder / "b.glb"};
    request.stages_folder.clear();
    const RunReport again = run_job(request);
    EXPECT_EQ(again.relief->input.calibration.focal_px, rectified.input.calibration.focal_px);
    EXPECT_EQ(again.relief->input.calibration.cx, rectified.input.calibration.cx);
    EXPECT_EQ(again.relief->surface.bounds.low.z, rectified.surface.bounds.low.z);

    request.config.input.calibration.file = folder / "pair.yml";
    request.stages_folder = folder / "stages";
    EXPECT_THROW(run_job(request), Error) << "would overwrite its input";
    request.config.input.calibration.rectify = readers::Rectify::never;
    EXPECT_THROW(run_job(request), Error) << "no rectified camera in the file";
}

TEST(Runner, AStereoFileIsAPair) {
    const test::TemporaryFolder folder;
    const Image left = readers::read_image(test::sample("left.png")),
                right = readers::read_image(test::sample("right.png"));
    std::string both =
        "P6\n" + std::to_string(2 * left.width) + " " + std::to_string(left.height) + "\n255\n";
    for (int y = 0; y < left.height; ++y)
        for (const Image* image : {&left, &right})
            both.append(reinterpret_cast<const char*>(image->at(0, y)),
                        3 * static_cast<std::size_t>(left.width));
    test::write_text(folder / "both.ppm", both);
    RunRequest request = pair_request(folder);
    request.outputs = {folder / "a.ply"};
    run_job(request);
    request.source = StereoFile{folder / "both.ppm"};
    request.outputs = {folder / "b.ply"};
    EXPECT_THROW(run_job(request), Error) << "the layout is not said";
    request.config.input.stereo.layout = readers::StereoLayout::side_by_side;
    EXPECT_EQ(run_job(request).relief->input.files.at(0).role, "stereo");
    EXPECT_EQ(test::read_text(folder / "a.ply"), test::read_text(folder / "b.ply"));
}

// A map of whole pixels is smoothed; what is measured against stays the map as it was given.
TEST(Runner, WholePixelsAreSmoothedWhereTheConfigurationAllows) {
    const test::TemporaryFolder folder;
    std::string pgm = "P5\n60 40\n255\n";
    for (int i = 0; i < 60 * 40; ++i) pgm += static_cast<char>(20 + (i % 60) / 7);
    test::write_text(folder / "d.pgm", pgm);
    const auto run = [&](stages::Dequantization dequantize, double max_error_px) {
        return run_job({.source = DisparityFiles{folder / "d.pgm"},
                        .outputs = {folder / "a.glb"},
                        .config = {.input = {.disparity = {.scale = 1}},
                                   .disparity = {.dequantize = dequantize},
                                   .budget = {.max_error_px = max_error_px}},
                        .report = folder / "r.json"});
    };
    const RunReport smooth = run(stages::Dequantization::automatic, 0),
                    exact = run(stages::Dequantization::none, 0);
    EXPECT_EQ(smooth.relief->disparity.quantum_px, 1);
    EXPECT_EQ(nlohmann::json::parse(report_json(smooth))["input"]["quantum_px"], 1);
    EXPECT_NEAR(smooth.quality.flat_rmse_px, 0.29, 0.03);
    EXPECT_EQ(exact.relief->disparity.quantum_px, 0);
    EXPECT_TRUE(nlohmann::json::parse(report_json(exact))["input"]["quantum_px"].is_null());
    EXPECT_NE(smooth.outputs[0].sha256, exact.outputs[0].sha256);
    EXPECT_EQ(run(stages::Dequantization::automatic, 0.9).relief->disparity.quantum_px, 0);
    EXPECT_EQ(run(stages::Dequantization::automatic, 1.5).relief->disparity.quantum_px, 1);
}

// Every fifth row of whole pixels is filled, and still known to be rounded; whole maps have no such stage.
TEST(Runner, SparseMapsAreFilledWhereTheConfigurationAllows) {
    const test::TemporaryFolder folder;
    std::string pgm = "P5\n60 40\n255\n";
    for (int i = 0; i < 60 * 40; ++i) pgm += static_cast<char>(i / 60 % 5 == 2 ? 20 + (i % 60) / 7 : 0);
    test::write_text(folder / "d.pgm", pgm);
    std::string mask = "P5\n60 40\n255\n" + std::string(60 * 40, '\xff');
    std::fill_n(mask.end() - 60 * 40, 60 * 10, '\0');
    test::write_text(folder / "mask.pgm", mask);
    const auto run = [&](config::Densification densification, std::string& told,
                         const char* masked = nullptr) {
        const RunRequest request{
            .source = DisparityFiles{.map = folder / "d.pgm", .mask = masked ? folder / masked : ""},
            .outputs = {folder / "a.glb"},
            .config = {.input = {.disparity = {.scale = 1}, .densify = densification}},
            .report = folder / "r.json"};
        RunLog log;
        log.decides = [&](const std::string& decision) {
            if (decision.starts_with("densify: ")) told = decision;
        };
        Backends backends;
        return run_job(request, backends, log);
    };
    std::string told;
    const RunReport filled = run(config::Densification::automatic, told);
    EXPECT_EQ(told,
              "densify: 20.0 % of the pixels are known, with unknown ones between them; 100.0 % are known "
              "when filled");
    EXPECT_GT(filled.quality.coverage, 0.95);
    EXPECT_EQ(filled.relief->disparity.quantum_px, 1);
    const auto input = nlohmann::json::parse(report_json(filled))["input"];
    EXPECT_NEAR(input["densified"]["measured_share"], 0.2, 1e-9);
    EXPECT_NEAR(input["densified"]["filled_share"], 0.8, 1e-9);
    const RunReport masked = run(config::Densification::automatic, told, "mask.pgm");
    const auto shares = origin_shares(masked.relief->disparity.map);
    ASSERT_TRUE(shares);
    EXPECT_NEAR(shares->measured + shares->filled, 0.75, 1e-9) << "nothing is filled where the mask hides";
    told.clear();
    EXPECT_FALSE(origin_shares(run(config::Densification::off, told).relief->disparity.map));
    EXPECT_EQ(told, "");
}

// What a budget and a share of the surface's error come to is what the report holds.
TEST(Runner, ReportHoldsTheConfigurationInEffect) {
    const test::TemporaryFolder folder;
    RunRequest request = sample_request(folder);
    request.config.budget.vertices = 500;
    request.config.exporting.tolerance_share = 0.1;
    const RunReport report = run_job(request);
    const SurfaceResult& surface = report.relief->surface;
    EXPECT_EQ(surface.config.mesh.spacing_px, surface.budget.spacing_px);
    EXPECT_EQ(surface.config.exporting.tolerance_px, surface.budget.tolerance_px);
    EXPECT_LT(surface.config.exporting.tolerance_px, request.config.exporting.tolerance_px);
    EXPECT_LE(surface.mesh.positions.size(), 500u);
}

}  // namespace
}  // namespace hexrelief::job
