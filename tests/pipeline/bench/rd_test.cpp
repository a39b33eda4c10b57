// Tests `hexrelief bench rd` on small synthetic maps in the data sets' layout, and its
// arithmetic at equal bytes.
#include "pipeline/bench/rd.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "pipeline/bench/rd_meshes.h"
#include "pipeline/bench/rd_peers.h"
#include "pipeline/bench/rd_rows.h"
#include "pipeline/data/error.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;

class BenchRd : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("hexrelief-bench-rd-" + std::to_string(getpid()));
        // A slanted floor with a box 12 px in front of it; raw / 8 = px.
        write_map("middlebury2001/venus", 90, 72, [](int x, int y) {
            const bool box = x >= 30 && x < 60 && y >= 20 && y < 50;
            return 60 + x / 2 + y + (box ? 96 : 0);
        });
    }
    void TearDown() override { fs::remove_all(folder_); }

    void write_map(const std::string& scene, int width, int height, int (*value)(int, int)) const {
        fs::create_directories(folder_ / scene);
        std::ofstream out(folder_ / scene / "disp.pgm", std::ios::binary);
        out << "P5\n" << width << ' ' << height << "\n255\n";
        for (int i = 0; i < width * height; ++i) out.put(static_cast<char>(value(i % width, i / width)));
    }

    RdOptions options() const {
        RdOptions options;
        options.data = folder_;
        options.threads = 1;
        options.spacings = {4, 6, 8};
        options.json = folder_ / "rd.json";
        return options;
    }
    fs::path write_text(const fs::path& name, const std::string& text) const {
        fs::create_directories((folder_ / name).parent_path());
        std::ofstream(folder_ / name) << text;
        return folder_ / name;
    }
    nlohmann::json json() const { return nlohmann::json::parse(std::ifstream(folder_ / "rd.json")); }

    fs::path folder_;
};

TEST_F(BenchRd, EveryMethodAtEverySpacingAndTheComparison) {
    std::ostringstream text;
    run_bench_rd(options(), text);
    const nlohmann::json table = json();
    std::map<std::string, int> points;
    std::map<double, int> bytes_of_default;
    for (const auto& point : table["points"]) {
        const std::string method = point["method"];
        ++points[method];
        EXPECT_EQ(point["map"], "venus");
        EXPECT_GT(point["bytes"], 50);
        EXPECT_GT(point["vertices"], 4);
        EXPECT_NEAR(point["bits_per_vertex"].get<double>(),
                    8.0 * point["bytes"].get<double>() / point["vertices"].get<double>(), 1e-9);
        EXPECT_GT(point["rmse_near_px"], 0);
        EXPECT_LT(point["rmse_near_px"], 10);
        EXPECT_LE(point["coverage"], point["slack_coverage"]);
        EXPECT_GE(point["hole_share"], 0);
        EXPECT_LT(point["hole_share"], 1);
        EXPECT_LT(point["hole_share_above"], 1);
        if (method == "default") {
            bytes_of_default[point["spacing_px"]] = point["bytes"];
            EXPECT_GT(point["hole_share"], 0) << "cut along its silhouettes";
            EXPECT_LT(point["position_bits"], 12) << "0.1 px of 90 px take fewer";
        } else if (point["spacing_px"].is_null()) {
            EXPECT_EQ(point["position_bits"], 12);
        }
    }
    EXPECT_EQ(points["default"], 3);
    EXPECT_EQ(points["quality"], 3);
    EXPECT_EQ(points["compact"], 3);
    EXPECT_EQ(points["paper"], 3);
    EXPECT_EQ(points["uniform"], 4) << "10, 6, 4 for the comparison, and 8";
    if (rd::has_simplification()) {
        EXPECT_GE(points["meshopt"], 4);
        EXPECT_GE(points["meshopt+cut"], 4);
    }
    EXPECT_GT(bytes_of_default[4], bytes_of_default[6]);
    EXPECT_GT(bytes_of_default[6], bytes_of_default[8]);

    ASSERT_EQ(table["at_equal_bytes"].size(), 3u);
    for (const auto& comparison : table["at_equal_bytes"])
        for (const auto& point : table["points"])
            if (point["method"] == "uniform" && point["spacing_px"] == comparison["uniform_spacing_px"]) {
                EXPECT_EQ(comparison["bytes"], point["bytes"]);
                EXPECT_NEAR(comparison["methods"]["uniform"]["duo_rmse_near_px"].get<double>(),
                            point["duo_rmse_near_px"].get<double>(), 1e-9);
            }
    for (const char* word : {"venus", "default", "uniform", "not there, left out: tsukuba", "at the "})
        EXPECT_NE(text.str().find(word), std::string::npos) << word << " in\n" << text.str();
}

TEST_F(BenchRd, ChoosesMethodsAndSpacings) {
    RdOptions o = options();
    o.maps = {"venus"};
    o.methods = {"compact"};
    o.spacings = {5};
    o.settings = {"export.tolerance_px=4", "export.tolerance_share=0"};
    std::ostringstream text;
    run_bench_rd(o, text);
    std::set<std::string> methods;
    const nlohmann::json table = json();  // kept alive while its points are read
    for (const auto& point : table["points"]) {
        methods.insert(point["method"].get<std::string>());
        if (point["method"] == "compact") {
            EXPECT_EQ(point["position_bits"], 4) << "90 px in steps of up to 8 px";
        }
    }
    EXPECT_EQ(methods, (std::set<std::string>{"compact", "uniform"}));
    EXPECT_EQ(text.str().find("left out"), std::string::npos);
}

TEST_F(BenchRd, SaysWhatIsWrong) {
    const auto failure = [&](auto change) {
        RdOptions o = options();
        change(o);
        std::ostringstream text;
        try {
            run_bench_rd(o, text);
        } catch (const Error& e) {
            return std::to_string(static_cast<int>(e.kind())) + ": " + e.what();
        }
        return std::string("nothing");
    };
    EXPECT_EQ(failure([](auto& o) { o.methods = {"defualt"}; }).find("2: --methods: unknown name 'defualt'"),
              0u);
    EXPECT_EQ(failure([](auto& o) { o.maps = {"conesM"}; }).find("2: --maps"), 0u) << "not among its sets";
    EXPECT_EQ(failure([](auto& o) { o.spacings = {}; }).find("2: --spacings"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.spacings = {1}; }).find("2: --spacings"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.settings = {"density.detial=1"}; }).find("2: --set density.detial=1"),
              0u);
    EXPECT_EQ(failure([](auto& o) { o.maps = {"cones"}; }).find("3: "), 0u);
    EXPECT_EQ(failure([](auto& o) { o.json = o.data / "nowhere" / "t.json"; }).find("4: "), 0u);
}

// SetUp()'s venus as one square of its floor.
constexpr const char* kFloor =
    "# x y disparity\nv 0 0 7.5\nv 90 0 13\nv 90 72 22\nv 0 72 16.5\nv 5 5 5\nf 1//1 2//2 3//1 -2\n";

TEST_F(BenchRd, ComparesWithPeersFiles) {
    write_text("peer/venus_cut_1.obj", kFloor);
    write_text("peer/venusL_1.obj", "of another map, not read");
    write_text("peer/venus_cut_1.txt", "no mesh, not read");
    RdOptions o = options();
    o.methods = {"compact"};
    o.peers = {"floor=" + (folder_ / "peer").string()};
    std::ostringstream text;
    run_bench_rd(o, text);
    const nlohmann::json table = json();
    std::vector<int> bits;
    for (const auto& point : table["points"])
        if (point["method"] == "floor") {
            bits.push_back(point["position_bits"]);
            EXPECT_EQ(point["vertices"], 4);
            EXPECT_EQ(point["triangles"], 2);
            EXPECT_NEAR(point["duo_rmse_near_px"].get<double>(), 6.5, 3) << "the box is missing";
            EXPECT_EQ(point["slack_coverage"], 1);
        }
    EXPECT_EQ(bits, (std::vector<int>{10, 12}));
    EXPECT_EQ(table["peers"].back(), "floor");
    for (const auto& comparison : table["at_equal_bytes"])
        EXPECT_TRUE(comparison["methods"].contains("floor"));
    for (const auto& mean : table["means"]) EXPECT_EQ(mean["method"], "compact");
    EXPECT_NE(text.str().find("floor"), std::string::npos);
}

TEST_F(BenchRd, RefusesPeersThatItCannotRead) {
    const auto reason = [&](const std::string& obj) {
        try {
            rd::read_peer_mesh(write_text("peer/venus_1.obj", obj));
        } catch (const Error& e) {
            return e.kind() == ErrorKind::input ? std::string(e.what()) : "no input error";
        }
        return std::string("nothing");
    };
    EXPECT_NE(reason("v 1 2 3\nv 1 2\n").find("line 2: a vertex needs three numbers"), std::string::npos);
    EXPECT_NE(reason("v 1 2 nan\n").find("line 1"), std::string::npos);
    EXPECT_NE(reason("v 1 2 3\nv 2 2 3\nf 1 2 3\n").find("line 3: a face uses vertex '3' of 2"),
              std::string::npos);
    EXPECT_NE(reason("v 1 2 3\nf 1 -2 1\n").find("'-2' of 1"), std::string::npos);
    EXPECT_NE(reason("v 1 2 3\nf 1 1x 1\n").find("'1x' of 1"), std::string::npos);
    EXPECT_NE(reason("v 1 2 3\nf 1 1\n").find("a face needs three corners"), std::string::npos);
    EXPECT_NE(reason("v 1 2 3\n").find("no triangle"), std::string::npos);
    EXPECT_EQ(reason(kFloor), "nothing");

    const auto kind = [&](const std::string& peer) {
        RdOptions o = options();
        o.peers = {peer};
        std::ostringstream text;
        try {
            run_bench_rd(o, text);
        } catch (const Error& e) {
            return static_cast<int>(e.kind());
        }
        return 0;
    };
    EXPECT_EQ(kind("peer"), 2);
    EXPECT_EQ(kind("=peer"), 2);
    EXPECT_EQ(kind("compact=" + (folder_ / "peer").string()), 2) << "a method's name";
    EXPECT_EQ(kind("mine=" + (folder_ / "nowhere").string()), 3);
}

rd::Point point(const std::string& method, std::size_t bytes, double duo) {
    rd::Point p{"m", method, 0, 0, 0, 0, bytes, 0, {}};
    p.quality.duo_rmse_near_px = duo;
    return p;
}

TEST(BenchRdRows, BetweenTwoPointsOnLogarithmicScales) {
    const std::vector<rd::Point> points = {point("a", 1000, 4), point("a", 100, 16), point("a", 10000, 1),
                                           point("b", 500, 9)};
    const auto duo = [&](const char* method, double bytes) {
        return rd::at_bytes(points, method, bytes, &stages::SurfaceQuality::duo_rmse_near_px);
    };
    EXPECT_DOUBLE_EQ(*duo("a", 1000), 4);
    EXPECT_NEAR(*duo("a", std::sqrt(100.0 * 1000)), 8, 1e-9);
    EXPECT_NEAR(*duo("a", std::sqrt(1000.0 * 10000)), 2, 1e-9);
    EXPECT_FALSE(duo("a", 99));
    EXPECT_FALSE(duo("a", 10001));
    EXPECT_DOUBLE_EQ(*duo("b", 500), 9);
    EXPECT_FALSE(duo("c", 500));
}

TEST(BenchRdRows, LeavesOutWhatAnotherPointOfTheMethodBeats) {
    const std::vector<rd::Point> points = {point("a", 100, 4), point("a", 200, 5), point("a", 200, 3),
                                           point("a", 300, 3), point("b", 900, 9)};
    std::vector<std::size_t> bytes;
    for (const rd::Point& p : rd::without_beaten(points, "a")) bytes.push_back(p.bytes);
    EXPECT_EQ(bytes, (std::vector<std::size_t>{100, 200, 300, 900})) << "b is another method";
}

TEST(BenchRdRows, SharesOfTheBestOtherMesher) {
    rd::Point uniform = point("uniform", 1000, 3);
    uniform.spacing_px = 6;
    const std::vector<std::string> others = {"uniform", "simple"};
    std::vector<rd::Comparison> comparisons;
    for (const double ours : {1.0, 4.0}) {
        const std::vector<rd::Point> points = {uniform, point("simple", 1000, 2), point("ours", 1000, ours)};
        comparisons.push_back(rd::compare(points, uniform, {"uniform", "simple", "ours"}));
        const auto best = rd::best_other(comparisons.back(), others);
        ASSERT_TRUE(best);
        EXPECT_EQ(best->method, "simple");
    }
    const auto mean = rd::mean_share(comparisons, "ours", others, 6);
    ASSERT_TRUE(mean);
    EXPECT_NEAR(mean->share, std::sqrt(0.5 * 2), 1e-12);
    EXPECT_EQ(mean->maps, 2);
    EXPECT_EQ(mean->maps_below, 1);
    EXPECT_FALSE(rd::mean_share(comparisons, "ours", others, 4));
}

DisparityMap plane_with_step() {
    DisparityMap map{40, 30, {}};
    for (int i = 0; i < 40 * 30; ++i)
        map.values.push_back(i % 40 < 20 ? 12 + 0.1f * float(i / 40) : 4 + 0.1f * float(i % 40));
    return map;
}

TEST(BenchRdMeshes, AGridTakesItsPixelsDisparities) {
    DisparityMap map = plane_with_step();
    const SurfaceMesh grid = rd::uniform_mesh(map, 0, 5);
    EXPECT_EQ(grid.disparities.size(), 9u * 7u);
    EXPECT_EQ(grid.triangles.size(), 8u * 6u * 2u);
    for (std::size_t i = 0; i < grid.disparities.size(); ++i)
        EXPECT_EQ(grid.disparities[i], map.at(int(grid.image_points[i].x), int(grid.image_points[i].y)));
    EXPECT_EQ(stages::measure_surface_quality(grid, map, 0, 1).slack_coverage, 1);
    // The right part is background: only triangles with a corner in the foreground remain.
    EXPECT_EQ(stages::measure_surface_quality(rd::uniform_mesh(map, 10, 5), map, 10, 1).slack_coverage, 1);
    EXPECT_EQ(rd::uniform_mesh(map, 10, 5).triangles.size(), 4u * 6u * 2u);
    map.at(7, 7) = kUnknownDisparity;
    for (const float d : rd::uniform_mesh(map, 0, 1).disparities) EXPECT_TRUE(DisparityMap::known(d));
}

TEST(BenchRdMeshes, StepsAreTakenOut) {
    const DisparityMap map = plane_with_step();
    const SurfaceMesh full = rd::uniform_mesh(map, 0, 1), cut = rd::without_steps(full, 4);
    EXPECT_EQ(full.triangles.size(), 39u * 29u * 2u);
    EXPECT_EQ(cut.triangles.size(), 38u * 29u * 2u);
    EXPECT_GT(stages::measure_surface_quality(full, map, 0, 1).sheet_share, 0.8);
    EXPECT_EQ(stages::measure_surface_quality(cut, map, 0, 1).sheet_share, 0);
}

TEST(BenchRdMeshes, SimplificationKeepsPlanes) {
    if (!rd::has_simplification()) GTEST_SKIP() << "built without meshoptimizer";
    const DisparityMap map = plane_with_step();
    const SurfaceMesh cut = rd::without_steps(rd::uniform_mesh(map, 0, 1), 4);
    const SurfaceMesh simple = rd::simplified_mesh(cut, 60);
    EXPECT_LE(simple.triangles.size(), 60u);
    EXPECT_LT(stages::measure_surface_quality(simple, map, 0, 1).rmse_near_px, 0.01);
}

}  // namespace
}  // namespace hexrelief::bench
