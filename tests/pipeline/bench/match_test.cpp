// Tests `hexrelief bench match` on small synthetic pairs in the data sets' layout.
#include "pipeline/bench/match/match.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "pipeline/bench/match/match_rows.h"
#include "pipeline/data/error.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 96, kHeight = 48;

// A wall at 4 px with a box at 12 px in front of it, both textured with noise.
int true_disparity(int x, int y) {
    return x >= 40 && x < 70 && y >= 12 && y < 36 ? 12 : 4;
}
std::uint8_t texture(int x, int y) {
    unsigned hash = static_cast<unsigned>(x + 1000) * 2654435761u ^ static_cast<unsigned>(y) * 2246822519u;
    hash ^= hash >> 15;
    return static_cast<std::uint8_t>((hash * 2654435761u) >> 24);
}

class BenchMatch : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("hexrelief-bench-match-" + std::to_string(getpid()));
        write_scene("middlebury2003/box-quarter", 4);
        write_scene("middlebury2006/box-half", 2);
    }
    void TearDown() override { fs::remove_all(folder_); }

    void write(const std::string& file, const std::function<int(int, int)>& value) const {
        fs::create_directories((folder_ / file).parent_path());
        std::ofstream out(folder_ / file, std::ios::binary);
        out << "P5\n" << kWidth << ' ' << kHeight << "\n255\n";
        for (int i = 0; i < kWidth * kHeight; ++i) out.put(static_cast<char>(value(i % kWidth, i / kWidth)));
    }
    void write_scene(const std::string& scene, int scale) const {
        write(scene + "/left.pgm", [](int x, int y) { return texture(x - true_disparity(x, y), y); });
        write(scene + "/right.pgm", texture);
        write(scene + "/disp.pgm", [&](int x, int y) { return scale * true_disparity(x, y); });
    }

    MatchOptions options() const {
        MatchOptions options;
        options.data = folder_;
        options.threads = 1;
        options.runs = 2;
        options.json = folder_ / "match.json";
        return options;
    }
    nlohmann::json run(const MatchOptions& o) const {
        std::ostringstream text;
        run_bench_match(o, text);
        text_ = text.str();
        return nlohmann::json::parse(std::ifstream(folder_ / "match.json"));
    }

    fs::path folder_;
    mutable std::string text_;
};

TEST_F(BenchMatch, EveryMethodOnEveryPairAndTheMeans) {
    const nlohmann::json table = run(options());
    std::map<std::string, int> rows;
    for (const auto& row : table["rows"]) {
        if (row["backend"] != "cpu") continue;
        ++rows[row["scene"].get<std::string>() + " " + row["method"].get<std::string>()];
        EXPECT_EQ(row["width"], kWidth);
        EXPECT_EQ(row["seconds"]["runs"].size(), 2u);
        EXPECT_GT(row["seconds"]["median"], 0);
        EXPECT_GE(row["disparities"], 16);
        EXPECT_LT(row["bad_2_nonoccluded_percent"], 20) << row["method"];
        EXPECT_LE(row["bad_2_percent"], row["bad_1_percent"]);
        EXPECT_EQ(row["truth_pixels"], kWidth * kHeight);
        EXPECT_LT(row["nonoccluded_pixels"], kWidth * kHeight);
        EXPECT_GT(row["edge_pixels"], 0);
        if (row["method"] == "opencv") {
            EXPECT_LT(row["coverage_percent"], 100);
            EXPECT_EQ(row["filled_percent"], 0);
        } else {
            EXPECT_EQ(row["coverage_percent"], 100);
            EXPECT_GT(row["filled_percent"], 0);
        }
    }
    const std::map<std::string, int> expected = {{"box-quarter sgm", 1},    {"box-quarter sgbm", 1},
                                                 {"box-quarter opencv", 1}, {"box-half sgm", 1},
                                                 {"box-half sgbm", 1},      {"box-half opencv", 1}};
    EXPECT_EQ(rows, expected);
    EXPECT_GE(table["means"].size(), 6u);
    for (const char* word : {"box-quarter", "96x48", "opencv", "mean of 1 small scene ", "bad-2"})
        EXPECT_NE(text_.find(word), std::string::npos) << word << " in\n" << text_;
}

TEST_F(BenchMatch, ChoosesScenesMethodsAndSettings) {
    MatchOptions o = options();
    o.scenes = {"box-half"};
    o.methods = {"sgm"};
    o.settings = {"disparity.num_disparities_px=48", "disparity.fill=none"};
    const nlohmann::json table = run(o);
    for (const auto& row : table["rows"]) {
        EXPECT_EQ(row["scene"], "box-half");
        EXPECT_EQ(row["method"], "sgm");
        EXPECT_EQ(row["disparities"], 48);
        EXPECT_EQ(row["filled_percent"], 0);
    }
    EXPECT_GE(table["rows"].size(), 1u);
}

TEST_F(BenchMatch, NamesNeedNotBeUtf8) {
    write_scene("middlebury2003/b\xffx-quarter", 4);
    MatchOptions o = options();
    o.scenes = {"b\xffx-quarter"};
    o.methods = {"sgm"};
    EXPECT_EQ(run(o)["rows"][0]["scene"], "b\uFFFDx-quarter");
}

TEST_F(BenchMatch, NoiseMakesItHarderAndIsAlwaysTheSame) {
    MatchOptions o = options();
    o.scenes = {"box-quarter"};
    o.methods = {"opencv"};
    o.runs = 1;
    const auto bad = [&] { return run(o)["rows"][0]["bad_1_nonoccluded_percent"].get<double>(); };
    const double clean = bad();
    o.disturbance.noise_percent = 50;
    const double noisy = bad();
    EXPECT_GT(noisy, clean + 2);
    EXPECT_EQ(bad(), noisy);
    EXPECT_NE(text_.find("Noise of 50 %"), std::string::npos);
}

TEST_F(BenchMatch, FindsPairsByTheirFilesAndScalesByTheirNames) {
    write_scene("middlebury2001/tsukuba", 16);
    write_scene("middlebury2001/venus", 8);
    write("middlebury2001/venus/disp_right.pgm", [](int, int) { return 8; });
    write_scene("middlebury2006/box-full", 1);
    for (const char* image : {"left_color", "right_color"})
        fs::copy(folder_ / "middlebury2006/box-full/left.pgm",
                 folder_ / "middlebury2006/box-full" / (std::string(image) + ".pgm"));
    write_scene("else/box", 1);
    write("middlebury2003/no-images-full/disp.pgm", [](int, int) { return 5; });
    std::vector<std::string> left_out, names;
    std::map<std::string, match::ScenePair> found;
    for (const match::ScenePair& scene : match::find_scenes(folder_, left_out)) {
        names.push_back(scene.name);
        found[scene.name] = scene;
    }
    EXPECT_EQ(names, (std::vector<std::string>{"tsukuba", "venus", "box-quarter", "box-full",
                                               "box-full-color", "box-half"}));
    ASSERT_EQ(left_out.size(), 1u);
    EXPECT_NE(left_out[0].find("else/box"), std::string::npos);
    EXPECT_EQ(found["tsukuba"].scale, 16);
    EXPECT_EQ(found["venus"].scale, 8);
    EXPECT_EQ(found["box-quarter"].scale, 4);
    EXPECT_EQ(found["box-half"].scale, 2);
    EXPECT_EQ(found["box-full"].scale, 1);
    EXPECT_EQ(found["box-full"].discontinuity_px, 2);
    EXPECT_EQ(found["box-half"].discontinuity_px, 1);
    EXPECT_EQ(found["box-full-color"].size, "full");
    EXPECT_EQ(found["box-full-color"].left.filename(), "left_color.pgm");
    EXPECT_EQ(found["venus"].right_truth.filename(), "disp_right.pgm");
    EXPECT_TRUE(found["tsukuba"].right_truth.empty());
}

TEST_F(BenchMatch, SaysWhatIsWrong) {
    const auto failure = [&](auto change) {
        MatchOptions o = options();
        change(o);
        std::ostringstream text;
        try {
            run_bench_match(o, text);
        } catch (const Error& e) {
            return std::to_string(static_cast<int>(e.kind())) + ": " + e.what();
        }
        return std::string("nothing");
    };
    EXPECT_NE(failure([](auto& o) {
                  o.scenes = {"box-hall"};
              }).find("2: --scenes: unknown name 'box-hall' (did you mean 'box-half'?)"),
              std::string::npos);
    EXPECT_EQ(failure([](auto& o) { o.methods = {"sgn"}; }).find("2: --methods"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.disturbance.noise_percent = -1; }).find("2: --noise"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.disturbance.gamma = 0; }).find("2: --gamma"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.disturbance.gain = -2; }).find("2: --gain"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.runs = 0; }).find("2: --runs"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.settings = {"disparity.nothing=1"}; }).find("2: "), 0u);
    EXPECT_EQ(failure([](auto& o) { o.data /= "nowhere"; }).find("3: "), 0u);
    EXPECT_EQ(failure([](auto& o) { o.json = o.data / "nowhere" / "t.json"; }).find("4: "), 0u);
}

TEST(BenchMatchDisturbance, NoiseHasItsDeviationAndLightItsCurve) {
    const Image grey{200, 100, 1, std::vector<std::uint8_t>(20000, 120)};
    StereoPair pair{grey, grey};
    match::Disturbance disturbance;
    match::disturb(pair, disturbance);
    EXPECT_EQ(pair.left.pixels, grey.pixels);
    EXPECT_EQ(pair.right.pixels, grey.pixels);

    disturbance.noise_percent = 4;
    match::disturb(pair, disturbance);
    EXPECT_NE(pair.left.pixels, pair.right.pixels) << "two sensors";
    for (const Image* image : {&pair.left, &pair.right}) {
        double sum = 0, squares = 0;
        for (const std::uint8_t sample : image->pixels) {
            sum += sample - 120.0;
            squares += (sample - 120.0) * (sample - 120.0);
        }
        EXPECT_NEAR(sum / 20000, 0, 0.3);
        EXPECT_NEAR(std::sqrt(squares / 20000), 10.2, 0.3);
    }

    pair = {grey, grey};
    match::disturb(pair, {0, 2, 0.5});
    EXPECT_EQ(pair.left.pixels, grey.pixels);
    EXPECT_EQ(pair.right.pixels[0], 28);  // 255 * 0.5 * (120 / 255)^2 = 28.2
    match::disturb(pair, {0, 1, 20});
    EXPECT_EQ(pair.right.pixels[0], 255);
}

TEST(BenchMatchRows, MeansAreOfOneSizeMethodAndBackend) {
    const auto row = [](const char* size, const char* method, double seconds, double bad2) {
        match::Row made;
        made.size = size;
        made.method = method;
        made.backend = "cpu";
        made.disparity.runs = {seconds};
        made.evaluation.bad_percent[2] = bad2;
        made.evaluation.edge_wrong_percent = bad2;
        made.evaluation.edge_unknown_percent = 1;
        return made;
    };
    const auto means =
        match::averages({row("small", "a", 1, 10), row("half", "a", 5, 50), row("small", "a", 2, 30)});
    ASSERT_EQ(means.size(), 2u);
    EXPECT_EQ(means[0].size, "small");
    EXPECT_EQ(means[0].scenes, 2);
    EXPECT_EQ(means[0].seconds, 1.5);
    EXPECT_EQ(means[0].bad2, 20);
    EXPECT_EQ(means[0].edge, 21);
    EXPECT_EQ(means[1].bad2, 50);
}

}  // namespace
}  // namespace hexrelief::bench
