// Tests `hexrelief bench sparse` on a small synthetic scene in the data sets' layout.
#include "pipeline/bench/sparse/sparse.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/bench/sparse/patterns.h"
#include "pipeline/data/error.h"
#include "pipeline/densify/sparsity.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kWide = 96, kHigh = 72;

// A box in front of a wall.
bool is_box(int x, int y) {
    return x >= 30 && x < 70 && y >= 20 && y < 55;
}

class BenchSparse : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("hexrelief-bench-sparse-" + std::to_string(getpid()));
        fs::create_directories(scene());
        write("left.pgm", [](int x, int y) { return is_box(x, y) ? 200 : 50; });
        write("right.pgm", [](int, int) { return 0; });
        write("disp.pgm", [](int x, int y) { return is_box(x, y) ? 80 : 40; });
    }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path scene() const { return folder_ / "middlebury2003" / "box-quarter"; }
    void write(const std::string& file, const std::function<int(int, int)>& value) const {
        std::ofstream out(scene() / file, std::ios::binary);
        out << "P5\n" << kWide << ' ' << kHigh << "\n255\n";
        for (int i = 0; i < kWide * kHigh; ++i) out.put(static_cast<char>(value(i % kWide, i / kWide)));
    }

    fs::path folder_;
};

TEST_F(BenchSparse, SaysWhatThinningCosts) {
    SparseOptions options;
    options.data = folder_;
    options.patterns = {"random-20"};
    options.threads = 1;
    options.json = folder_ / "sparse.json";
    std::ostringstream text;
    run_bench_sparse(options, text);
    std::ifstream file(options.json);
    const auto rows = nlohmann::json::parse(file)["rows"];
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0]["pattern"], "whole");
    EXPECT_EQ(rows[1]["pattern"], "random-20");
    EXPECT_NEAR(rows[1]["known_share"].get<double>(), 0.2, 0.02);
    EXPECT_LT(rows[1]["wrong_share"].get<double>(), 0.005);
    EXPECT_EQ(rows[1]["unknown_share"].get<double>(), 0);
    EXPECT_NE(text.str().find("geometric mean of 1 ratios"), std::string::npos);
}

TEST_F(BenchSparse, UnknownNamesAreUsageErrors) {
    SparseOptions options;
    options.data = folder_;
    options.patterns = {"rows"};
    std::ostringstream text;
    EXPECT_THROW(run_bench_sparse(options, text), Error);
    options.patterns = {};
    options.scenes = {"ball"};
    EXPECT_THROW(run_bench_sparse(options, text), Error);
}

TEST(SparsePatterns, KeepWhatTheyPromiseAndAreSparse) {
    const DisparityMap map{400, 300, std::vector<float>(400 * 300, 7.0f)};
    const double shares[] = {0.2, 0.05, 0.2, 0.05, 0.075};
    for (std::size_t i = 0; i < sparse::patterns().size(); ++i) {
        const densify::Sparsity sparsity =
            densify::measure_sparsity(sparse::thinned(map, sparse::patterns()[i]));
        EXPECT_NEAR(sparsity.known_share, shares[i], 0.01) << sparse::patterns()[i];
        EXPECT_TRUE(sparsity.is_sparse()) << sparse::patterns()[i];
    }
}

}  // namespace
}  // namespace hexrelief::bench
