// Tests `hexrelief bench table2` on small synthetic maps in the data sets' layout.
#include "pipeline/bench/table2.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/bench/table2_paper.h"
#include "pipeline/data/error.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;

class BenchTable2 : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("hexrelief-bench-" + std::to_string(getpid()));
        write_map("middlebury2001/tsukuba", 64, 48);
        write_map("middlebury2003/cones-quarter", 70, 60);
    }
    void TearDown() override { fs::remove_all(folder_); }

    void write_map(const std::string& scene, int width, int height) const {
        fs::create_directories(folder_ / scene);
        std::ofstream out(folder_ / scene / "disp.pgm", std::ios::binary);
        out << "P5\n" << width << ' ' << height << "\n255\n";
        for (int i = 0; i < width * height; ++i) out.put(static_cast<char>(40 + i % width + i / width));
    }

    Table2Options options() const {
        Table2Options options;
        options.data = folder_;
        options.runs = 2;
        options.threads = 1;
        options.json = folder_ / "table.json";
        return options;
    }
    nlohmann::json json() const { return nlohmann::json::parse(std::ifstream(folder_ / "table.json")); }

    fs::path folder_;
};

TEST_F(BenchTable2, EveryMapMethodAndSetBesideThePapersFigures) {
    std::ostringstream text;
    run_bench_table2(options(), text);
    const nlohmann::json table = json();
    std::map<std::string, int> cpu_rows;
    for (const auto& row : table["rows"]) {
        if (row["backend"] != "cpu") continue;
        ++cpu_rows[row["map"].get<std::string>() + " " + row["method"].get<std::string>()];
        EXPECT_EQ(row["seconds"]["runs"].size(), 2u);
        EXPECT_GT(row["seconds"]["median"], 0);
        EXPECT_GE(row["seconds"]["spread"], 0);
        EXPECT_EQ(row["surface_seconds"]["runs"].size(), 2u);
        EXPECT_GT(row["surface_seconds"]["median"], 0);
        EXPECT_GT(row["percent_cost"], 0);
        EXPECT_LT(row["weights_percent"]["p5"], row["weights_percent"]["p95"]);
        EXPECT_GT(row["median_angle_deg"], row["percentile1_angle_deg"]);
        EXPECT_GT(row["honeycomb_cells"], 5);
    }
    const std::map<std::string, int> expected = {
        {"tsukuba sequential", 1}, {"tsukuba paper", 1}, {"tsukuba som", 1}, {"tsukuba default", 1},
        {"cones sequential", 1},   {"cones paper", 1},   {"cones som", 1},   {"cones default", 1},
        {"conesS sequential", 1},  {"conesS paper", 1},  {"conesS som", 1},  {"conesS default", 1}};
    EXPECT_EQ(cpu_rows, expected);
    std::map<std::string, double> tsukuba_cost;
    for (const auto& row : table["rows"])
        if (row["map"] == "tsukuba") tsukuba_cost[row["method"]] = row["percent_cost"];
    EXPECT_LT(tsukuba_cost["default"], 0.5 * tsukuba_cost["som"]) << "only the default is balanced";
    EXPECT_LT(tsukuba_cost["default"], 0.5 * tsukuba_cost["paper"]);
    for (const auto& row : table["rows"])
        if (row["map"] == "conesS" && row["method"] == "paper") {
            EXPECT_EQ(row["ssr"], 4);
            EXPECT_EQ(row["crr"], 20);
            EXPECT_EQ(row["iterations"], 1500);
            EXPECT_EQ(row["cell_columns"], 4);
            EXPECT_EQ(row["columns"], 12);
            EXPECT_EQ(row["paper"]["gpu_percent_cost"], 18.95);
        }
    EXPECT_GE(table["averages"].size(), 6u);  // two sets
    EXPECT_EQ(table["missing"].size(), 15u);
    for (const char* word : {"tsukuba", "conesS", "64x48", "sequential", "mean of 2 maps", "mean of 1 map",
                             "18.95", "left out: teddyL"})
        EXPECT_NE(text.str().find(word), std::string::npos) << word << " in\n" << text.str();
}

TEST_F(BenchTable2, SettingsAreTheDefaultMethodsAlone) {
    const auto costs = [&](const std::vector<std::string>& settings) {
        Table2Options chosen = options();
        chosen.maps = {"tsukuba"};
        chosen.methods = {"som", "default"};
        chosen.settings = settings;
        std::ostringstream text;
        run_bench_table2(chosen, text);
        std::map<std::string, double> found;
        const nlohmann::json table = json();  // kept alive while its rows are read
        for (const auto& row : table["rows"])
            if (row["backend"] == "cpu")
                found[row["method"].get<std::string>()] = row["percent_cost"].get<double>();
        return found;
    };
    auto own = costs({}), other = costs({"density.exponent=1"});
    EXPECT_EQ(own.at("som"), other.at("som"));
    EXPECT_NE(own.at("default"), other.at("default"));
    EXPECT_THROW(costs({"no.such.key=1"}), Error);
}

TEST_F(BenchTable2, ChoosesMapsAndMethods) {
    Table2Options o = options();
    o.maps = {"cones"};
    o.methods = {"default"};
    o.runs = 1;
    std::ostringstream text;
    run_bench_table2(o, text);
    const nlohmann::json table = json();  // kept alive while its rows are read
    for (const auto& row : table["rows"]) {
        EXPECT_EQ(row["map"], "cones");
        EXPECT_EQ(row["method"], "default");
    }
    EXPECT_EQ(text.str().find("left out"), std::string::npos) << "nothing that was asked for is missing";
}

TEST_F(BenchTable2, SaysWhatIsWrong) {
    const auto failure = [&](auto change) {
        Table2Options o = options();
        change(o);
        std::ostringstream text;
        try {
            run_bench_table2(o, text);
        } catch (const Error& e) {
            return std::to_string(static_cast<int>(e.kind())) + ": " + e.what();
        }
        return std::string("nothing");
    };
    EXPECT_NE(failure([](auto& o) {
                  o.maps = {"conez"};
              }).find("2: --maps: unknown name 'conez' (did you mean 'cones'?)"),
              std::string::npos);
    EXPECT_EQ(failure([](auto& o) { o.methods = {"cuda"}; }).find("2: --methods"), 0u);
    EXPECT_EQ(failure([](auto& o) { o.maps = {"teddyL"}; }).find("3: "), 0u);
    EXPECT_EQ(failure([](auto& o) { o.data /= "nowhere"; }).find("3: "), 0u);
    EXPECT_EQ(failure([](auto& o) { o.json = o.data / "nowhere" / "t.json"; }).find("4: "), 0u);
}

// The paper prints each set's means, which reveal errors in copying its table.
TEST(BenchTable2Paper, FiguresHaveThePapersMeans) {
    struct Means {
        const char* set;
        double gpu_s, cpu_s, gpu_cost, cpu_cost;
    };
    for (const Means& m : {Means{"first", 0.33, 2.32, 21.37, 21.47}, Means{"S", 0.63, 3.46, 21.16, 20.86},
                           Means{"M", 1.08, 13.69, 21.97, 20.59}, Means{"L", 2.00, 79.48, 22.66, 23.45}}) {
        double gpu_s = 0, cpu_s = 0, gpu_cost = 0, cpu_cost = 0;
        int n = 0;
        for (const table2::PaperMap& map : table2::kPaperMaps) {
            if (map.set != std::string(m.set)) continue;
            ++n;
            gpu_s += map.gpu_s;
            cpu_s += map.cpu_s;
            gpu_cost += map.gpu_cost;
            cpu_cost += map.cpu_cost;
        }
        ASSERT_GT(n, 3);
        EXPECT_NEAR(gpu_s / n, m.gpu_s, 0.0051) << m.set;
        EXPECT_NEAR(cpu_s / n, m.cpu_s, 0.0051) << m.set;
        EXPECT_NEAR(gpu_cost / n, m.gpu_cost, 0.0051) << m.set;
        EXPECT_NEAR(cpu_cost / n, m.cpu_cost, 0.0051) << m.set;
    }
}

}  // namespace
}  // namespace hexrelief::bench
