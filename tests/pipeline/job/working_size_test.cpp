// Pairs that are matched and meshed smaller than they are, with the texture and the space of the full pair.
#include "pipeline/job/pairs/working_size.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/job/disparities.h"
#include "pipeline/job/runner.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

constexpr int kWorking_px = 320;  // the samples' width

// Returns the image with every pixel repeated, so that its means over squares of 2 x 2 px are its pixels.
Image doubled(const Image& image) {
    Image out{2 * image.width, 2 * image.height, image.channels, {}};
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x)
            out.pixels.insert(out.pixels.end(), image.at(x / 2, y / 2),
                              image.at(x / 2, y / 2) + image.channels);
    return out;
}

void write_ppm(const Image& image, const std::string& path) {
    test::write_text(path, "P6\n" + std::to_string(image.width) + " " + std::to_string(image.height) +
                               "\n255\n" + std::string(image.pixels.begin(), image.pixels.end()));
}

class WorkingSize : public ::testing::Test {
  protected:
    WorkingSize() {
        write_ppm(doubled(readers::read_image(test::sample("left.png"))), folder_ / "left.ppm");
        write_ppm(doubled(readers::read_image(test::sample("right.png"))), folder_ / "right.ppm");
        test::write_text(folder_ / "camera",
                         "{focal_px: 640, baseline_m: 0.16, cx: 320, cy: 240, width: 640, height: 480}");
    }

    // The samples' pair at twice its size, searched from 4 to 84 px.
    RunRequest request(int working_px, const std::string& output) const {
        return {.source = PairFiles{folder_ / "left.ppm", folder_ / "right.ppm"},
                .outputs = {folder_ / output},
                .config = {
                    .input = {.calibration = {.file = folder_ / "camera"}},
                    .disparity = {.working_px = working_px, .min_disparity_px = 4, .num_disparities_px = 80},
                    .mesh = {.spacing_px = 12},
                    .exporting = {.texture = exporters::TextureFormat::png, .texture_crop = false}}};
    }

    const test::TemporaryFolder folder_;
};

TEST(Reduction, IsTheLeastWholeNumberThatMakesAPairSmallEnough) {
    EXPECT_EQ(reduction_to(0, 9000), 1);
    EXPECT_EQ(reduction_to(3000, 2960), 1);
    EXPECT_EQ(reduction_to(3000, 3000), 1);
    EXPECT_EQ(reduction_to(3000, 3001), 2);
    EXPECT_EQ(reduction_to(3000, 8064), 3);
}

// Returns a picture of this width and three quarters of its height: grain, or the same blurred.
Image grain(int width, int blurs) {
    Image image{width, width * 3 / 4, 1, {}};
    std::uint32_t state = 1;
    for (int i = 0; i < image.width * image.height; ++i)
        image.pixels.push_back(static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24));
    for (const int step : {1, width})
        for (int i = 0; i < blurs; ++i)
            for (std::size_t p = 0; p + 2 * step < image.pixels.size(); ++p)
                image.pixels[p] = static_cast<std::uint8_t>(
                    (image.pixels[p] + 2 * image.pixels[p + step] + image.pixels[p + 2 * step] + 2) / 4);
    return image;
}

TEST(Reduction, HalvesSoftPicturesAsLongAsTheyKeepTheirSize) {
    EXPECT_EQ(reduction_of_soft(grain(1800, 0), 3000, 2), 1);
    EXPECT_EQ(reduction_of_soft(grain(1800, 8), 3000, 2), 2);
    EXPECT_EQ(reduction_of_soft(grain(1800, 8), 3000, 1), 2);
    EXPECT_EQ(reduction_of_soft(grain(1799, 8), 3000, 2), 1) << "899 px would remain";
    EXPECT_EQ(reduction_of_soft(grain(1800, 8), 0, 2), 1) << "never";
    EXPECT_EQ(reduction_of_soft(grain(1800, 0), 1000, 2), 2);
}

TEST(Reduction, HalvesSoftPicturesOnlyIfTheirPointsSayTheCamera) {
    const Image soft = grain(1800, 8);
    const auto reduced_by = [&](std::optional<alignment::Verdict> verdict) {
        RunInput input{InputPair{{soft, soft}}};
        if (verdict) std::get<InputPair>(input.views).alignment.emplace().verdict = *verdict;
        input.calibration = {800, 900, 675, 0.1, 3, true, 1800, 1350, 33};
        reduce_pair(input, {}, 1, {});
        return input.reduced_by();
    };
    EXPECT_EQ(reduced_by(std::nullopt), 1);
    EXPECT_EQ(reduced_by(alignment::Verdict::rectified), 1);
    EXPECT_EQ(reduced_by(alignment::Verdict::aligned), 2);
}

TEST(Reduction, KeepsWhatTheRangeHolds) {
    stages::DisparityConfig config{.min_disparity_px = -5, .num_disparities_px = 24, .farthest_px = -4};
    const stages::DisparityConfig half = for_reduced(config, 2);
    EXPECT_EQ(half.min_disparity_px, -3);
    EXPECT_EQ(half.num_disparities_px, 13) << "up to 9.5 px";
    EXPECT_EQ(half.farthest_px, -2);
    const stages::DisparityConfig chosen = for_reduced(stages::DisparityConfig{}, 2);
    EXPECT_EQ(chosen.num_disparities_px, 0);
    EXPECT_TRUE(std::isnan(chosen.farthest_px));
    stages::DensityConfig density{.background_threshold_px = 9};
    EXPECT_EQ(for_reduced(density, 2).background_threshold_px, 4.5);
}

TEST(Reduction, CutsWhatIsLeftAndHidesWhatIsHiddenInPart) {
    const Image picture{641, 49, 1, std::vector<std::uint8_t>(641 * 49, 7)};
    RunInput input{InputPair{{picture, picture}}};
    input.mask = {641, 49, std::vector<std::uint8_t>(641 * 49, 1)};
    input.mask.kept[641 + 2] = 0;
    input.calibration = {800, 320.5, 20, 0.1, 3, true, 641, 49, 33};
    stages::DisparityConfig config{.working_px = 330};
    reduce_pair(input, config, 1, {});
    ASSERT_EQ(input.reduced_by(), 2);
    EXPECT_EQ(input.color().width, 320);
    EXPECT_EQ(input.pair()->views.right.height, 24);
    EXPECT_EQ(input.texture().width, 640);
    EXPECT_EQ(input.texture().height, 48);
    EXPECT_EQ(input.mask.width, 320);
    EXPECT_EQ(std::count(input.mask.kept.begin(), input.mask.kept.end(), 0), 1);
    EXPECT_EQ(input.mask.kept[1], 0);
    const Calibration& camera = input.calibration;
    EXPECT_EQ(camera.focal_px, 400);
    EXPECT_EQ(camera.cx, 160.25);
    EXPECT_EQ(camera.cy, 10);
    EXPECT_EQ(camera.doffs_px, 1.5);
    EXPECT_EQ(camera.baseline_m, 0.1);
    EXPECT_EQ(camera.width, 320);
    EXPECT_EQ(camera.ndisp_px, 17);

    RunInput whole{InputPair{{picture, picture}}};
    config.working_px = 641;
    reduce_pair(whole, config, 1, {});
    EXPECT_EQ(whole.reduced_by(), 1);
    EXPECT_EQ(&whole.texture(), &whole.color());
}

// The reduced pair is the samples' own, so that its mesh is that of the samples to the bit.
TEST_F(WorkingSize, GivesTheMeshOfTheReducedPairAndTheTextureOfTheFullOne) {
    RunRequest small = request(0, "small.obj");
    small.source = PairFiles{test::sample("left.png"), test::sample("right.png")};
    small.config.input.calibration.file = test::sample("calib.txt");
    small.config.disparity.min_disparity_px = 2;
    small.config.disparity.num_disparities_px = 40;
    small.config.surface.views = SurfaceViews::left;  // textures of two views are laid out by their size
    const RunReport expected = run_job(small);
    RunRequest large = request(kWorking_px, "reduced.obj");
    large.config.surface.views = SurfaceViews::left;
    const RunReport reduced = run_job(large);
    EXPECT_EQ(reduced.relief->disparity.map.values, expected.relief->disparity.map.values);
    EXPECT_EQ(reduced.relief->disparity.matched->min_disparity_px, 2);
    const auto vertices = [&](const char* name) {
        const std::string text = test::read_text(folder_ / name);
        return text.substr(text.find("\nv "));
    };
    EXPECT_EQ(vertices("reduced.obj"), vertices("small.obj"));
    EXPECT_EQ(readers::read_image(folder_ / "small_texture.png").width, 320);
    EXPECT_EQ(readers::read_image(folder_ / "reduced_texture.png").pixels,
              readers::read_image(folder_ / "left.ppm").pixels);
    const auto json = nlohmann::json::parse(report_json(reduced));
    EXPECT_EQ(json["input"]["width"], 320);
    EXPECT_EQ(json["input"]["reduced_by"], 2);
    EXPECT_EQ(json["config"]["disparity"]["num_disparities_px"], 80) << "as it was given";
}

TEST_F(WorkingSize, KeepsPointsWhereTheyAreInSpace) {
    const RunReport full = run_job(request(0, "full.glb")), reduced = run_job(request(kWorking_px, "r.glb"));
    EXPECT_EQ(full.relief->disparity.map.width, 640);
    const SurfaceResult &a = full.relief->surface, &b = reduced.relief->surface;
    EXPECT_TRUE(b.mesh.metric);
    EXPECT_NEAR(b.nearest(), a.nearest(), 0.02 * a.nearest());
    int close = 0;
    const DisparityMap &large = full.relief->disparity.map, &small = reduced.relief->disparity.map;
    for (int y = 0; y < small.height; ++y)
        for (int x = 0; x < small.width; ++x)
            close += std::abs(2 * small.at(x, y) - large.at(2 * x, 2 * y)) < 1;
    EXPECT_GT(close, 0.9 * small.width * small.height) << "within a pixel of the full pair";
    EXPECT_LT(2 * b.mesh.positions.size(), a.mesh.positions.size()) << "the spacing follows";
}

TEST_F(WorkingSize, GivesTheSameBytesOnAnyNumberOfThreads) {
    std::vector<std::string> bytes;
    for (const int threads : {1, 2, 3}) {
        RunRequest threaded = request(kWorking_px, "a.glb");
        threaded.config.run.threads = threads;
        run_job(threaded);
        bytes.push_back(test::read_text(folder_ / "a.glb"));
    }
    EXPECT_EQ(bytes[0], bytes[1]);
    EXPECT_EQ(bytes[0], bytes[2]);
    EXPECT_CONTAINS(bytes[0], "\"working_px\":320");
}

TEST_F(WorkingSize, TooSmallIsAMistakeInTheConfiguration) {
    const std::vector<std::string> run = {
        "run",  "--left", folder_ / "left.ppm", "--right", folder_ / "right.ppm", "-o", folder_ / "a.glb",
        "--set"};
    const auto with = [&](const char* setting) {
        std::vector<std::string> arguments = run;
        arguments.emplace_back(setting);
        return arguments;
    };
    test::expect_failure(
        with("disparity.working_px=319"), 2,
        "disparity.working_px must be 0, for the pictures' own size, or at least 320, not 319");
    test::expect_failure(with("disparity.working_px=-1"), 2, "disparity.working_px");
    const test::ProcessResult told = test::expect_success(with("disparity.working_px=320"));
    EXPECT_CONTAINS(told.out, "matched and meshed at 320 x 240 px, 1/2 of the picture's size");
}

}  // namespace
}  // namespace hexrelief::job
