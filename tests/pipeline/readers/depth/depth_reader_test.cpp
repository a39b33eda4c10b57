#include "pipeline/readers/depth/depth_reader.h"

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

// Returns 16-bit samples in PNG's byte order.
Bytes wide(const std::vector<int>& samples) {
    Bytes bytes;
    for (const int sample : samples) {
        bytes.push_back(static_cast<std::uint8_t>(sample >> 8));
        bytes.push_back(static_cast<std::uint8_t>(sample));
    }
    return bytes;
}

DepthFile read_wide(const std::vector<int>& samples, const DepthFileConfig& config = {}) {
    const Folder folder;
    return read_depth_map(
        folder.write("d.png", make_png(static_cast<int>(samples.size()), 1, wide(samples), {.bits = 16})),
        config);
}

DepthFile read_bytes_map(const Bytes& samples, const DepthFileConfig& config) {
    const Folder folder;
    return read_depth_map(folder.write("d.png", make_png(static_cast<int>(samples.size()), 1, samples, {})),
                          config);
}

DepthFile read_floats(const std::vector<float>& samples, const DepthFileConfig& config = {}) {
    const Folder folder;
    return read_depth_map(folder.write("d.pfm", make_pfm(static_cast<int>(samples.size()), 1, samples)),
                          config);
}

TEST(DepthReader, SixteenBitsAreMillimetresAndFloatsMetres) {
    const DepthFile wide = read_wide({1500, 0, 65535, 250});
    EXPECT_EQ(wide.map.values, (std::vector<float>{1.5f, kInf, kInf, 0.25f}));
    EXPECT_EQ(wide.map.width, 4);
    EXPECT_EQ(wide.map.height, 1);
    EXPECT_TRUE(wide.map.metric);
    EXPECT_DOUBLE_EQ(wide.map.step, 0.001);
    EXPECT_EQ(wide.believed, "16-bit integers, mm");
    const DepthFile floats = read_floats({1.5f, 0, -2, kNaN, kInf, 0.25f, 1e10f});
    EXPECT_EQ(floats.map.values, (std::vector<float>{1.5f, kInf, kInf, kInf, kInf, 0.25f, kInf}));
    EXPECT_EQ(floats.map.step, 0);
    EXPECT_EQ(floats.believed, "floats, m");
}

TEST(DepthReader, UnitsAreMetresMillimetresOrAnyScale) {
    EXPECT_EQ(read_wide({3, 65535}, {.unit = "m"}).map.values, (std::vector<float>{3, kInf}));
    EXPECT_EQ(read_floats({3}, {.unit = "mm"}).map.values[0], 0.003f);
    const DepthFile scaled = read_wide({5000}, {.unit = "5000"});  // as in the TUM benchmark
    EXPECT_EQ(scaled.map.values[0], 1);
    EXPECT_EQ(scaled.believed, "16-bit integers, 1/5000 m");
    EXPECT_EQ(read_bytes_map({51}, {.unit = "25.5"}).map.values[0], 2);
}

TEST(DepthReader, InverseDepthsAreOneOver) {
    const DepthFile file = read_floats({4, 0, 0.5f, -1, kNaN}, {.kind = DepthKind::inverse_depth});
    EXPECT_EQ(file.map.values, (std::vector<float>{0.25f, kInf, 2, kInf, kInf}));
    EXPECT_TRUE(file.map.metric);
    const auto scaled = [](const std::string& unit) {
        return read_floats({4}, {.kind = DepthKind::inverse_depth, .unit = unit}).map.values[0];
    };
    EXPECT_FLOAT_EQ(scaled("mm"), 0.00025f) << "4 over a millimetre";
    EXPECT_FLOAT_EQ(scaled("2"), 0.5f) << "samples divided by 2";
    const DepthFile whole = read_wide({1000}, {.kind = DepthKind::inverse_depth, .unit = "2000"});
    EXPECT_EQ(whole.map.values[0], 2);
    EXPECT_TRUE(whole.map.is_inverse);
    EXPECT_DOUBLE_EQ(whole.map.step, 1 / 2000.0);
}

TEST(DepthReader, AffineInverseTakesShiftAndScale) {
    DepthFileConfig config{.kind = DepthKind::affine_inverse, .affine_shift = 0.5, .affine_scale = 0.25};
    const DepthFile file = read_floats({2, 0, -2, -4, kNaN}, config);
    EXPECT_EQ(file.map.values, (std::vector<float>{1, 2, kInf, kInf, kInf}));
    EXPECT_TRUE(file.map.metric);
    EXPECT_EQ(file.believed, "floats, depth = 1 / (0.5 + 0.25 * sample), m");
    EXPECT_EQ(read_bytes_map({2, 0}, config).map.values, (std::vector<float>{1, 2})) << "0 is a sample";
    config.unknown = 0;
    EXPECT_EQ(read_bytes_map({2, 0}, config).map.values, (std::vector<float>{1, kInf}));
    EXPECT_EQ(read_floats({4}, {.kind = DepthKind::affine_inverse, .affine_scale = 0.5}).map.values[0], 0.5f);
    EXPECT_EQ(read_floats({4}, {.kind = DepthKind::affine_inverse, .affine_shift = -2}).map.values[0], 0.5f);
}

TEST(DepthReader, AffineInverseWithoutShiftAndScaleIsRelative) {
    const DepthFile file = read_bytes_map({255, 0, 85, 170}, {.kind = DepthKind::affine_inverse});
    EXPECT_FALSE(file.map.metric);
    EXPECT_FLOAT_EQ(file.map.values[0], 1);
    EXPECT_FLOAT_EQ(file.map.values[1], 10);
    EXPECT_FLOAT_EQ(file.map.values[2], 2.5f);
    EXPECT_CONTAINS(file.believed, "relative");
    const DepthFile flat = read_floats({7, 7}, {.kind = DepthKind::affine_inverse});
    EXPECT_EQ(flat.map.values, (std::vector<float>{1, 1}));
}

TEST(DepthReader, AffineDepthTakesShiftAndScale) {
    DepthFileConfig config{.kind = DepthKind::affine_depth, .affine_shift = 0.5, .affine_scale = 2};
    const DepthFile file = read_floats({0, 1, -1, kNaN}, config);
    EXPECT_EQ(file.map.values, (std::vector<float>{0.5f, 2.5f, kInf, kInf}));
    EXPECT_TRUE(file.map.metric);
    EXPECT_EQ(file.believed, "floats, depth = 0.5 + 2 * sample, m");
    EXPECT_EQ(read_bytes_map({2, 0}, config).map.values, (std::vector<float>{4.5f, 0.5f})) << "0 is a sample";
    config.unit = "mm";
    EXPECT_FLOAT_EQ(read_floats({1}, config).map.values[0], 0.0025f);
}

TEST(DepthReader, AffineDepthWithoutShiftAndScaleIsRelative) {
    const DepthFile file = read_bytes_map({255, 0, 85}, {.kind = DepthKind::affine_depth});
    EXPECT_FALSE(file.map.metric);
    EXPECT_FLOAT_EQ(file.map.values[0], 10);
    EXPECT_FLOAT_EQ(file.map.values[1], 1);
    EXPECT_FLOAT_EQ(file.map.values[2], 4);
    EXPECT_CONTAINS(file.believed, "the smallest samples nearest (if farthest: --depth-kind affine_inverse)");
    const DepthFile inverse = read_bytes_map({255, 0, 85}, {.kind = DepthKind::affine_inverse});
    EXPECT_CONTAINS(inverse.believed, "the largest samples nearest (if farthest: --depth-kind affine_depth)");
}

TEST(DepthReader, WholeNumbersOfFloatsMayBeMillimetres) {
    EXPECT_CONTAINS(read_floats({1500, 0, 700}).doubt, "give --depth-unit mm");
    EXPECT_EQ(read_floats({1500, 700}, {.unit = "m"}).doubt, "");
    EXPECT_EQ(read_floats({1500.5f, 700}).doubt, "");
    EXPECT_EQ(read_floats({15, 7}).doubt, "");
}

TEST(DepthReader, MultiplesOfEightMayBeTurnedBits) {
    std::vector<int> sun, even;
    for (int i = 1; i <= 100; ++i) {
        sun.push_back(8 * (1000 + i));
        even.push_back(2 * (1000 + i));
    }
    EXPECT_CONTAINS(read_wide(sun).doubt, "--depth-unit 8000");
    EXPECT_EQ(read_wide(sun, {.unit = "8000"}).doubt, "");
    EXPECT_FLOAT_EQ(read_wide(sun, {.unit = "8000"}).map.values[0], 1.001f);
    EXPECT_EQ(read_wide(even).doubt, "");
    EXPECT_EQ(read_wide({1000, 1008, 1016}).doubt, "") << "too few to tell";
}

TEST(DepthReader, TheCamerasFileMaySayTheUnit) {
    const Folder folder;
    const auto depth = [&](const Bytes& bytes, const DepthFileConfig& config, double per_m) {
        return read_depth_map(folder.write("d", bytes), config, {}, per_m).map.values[0];
    };
    const Bytes tenths = make_png(1, 1, wide({10000}), {.bits = 16});
    EXPECT_EQ(depth(tenths, {}, 10000), 1);
    EXPECT_EQ(depth(tenths, {.unit = "mm"}, 10000), 10);
    EXPECT_EQ(depth(make_pfm(1, 1, {2}), {}, 10000), 2) << "metres";
    EXPECT_EQ(depth(make_png(1, 1, {50}, {}), {}, 25), 2);
}

TEST(DepthReader, AnUnknownSampleReplacesTheFormatsOwn) {
    EXPECT_EQ(read_wide({1000, 0, 65535, 7}, {.unknown = 7}).map.values,
              (std::vector<float>{1, kInf, 65.535f, kInf}))
        << "a depth of 0 is none";
    EXPECT_EQ(read_floats({1, -99, 40}, {.unknown = 40}).map.values, (std::vector<float>{1, kInf, kInf}));
}

TEST(DepthReader, IntegersWithoutAUnitAreRefused) {
    EXPECT_CONTAINS(error_of([] { read_bytes_map({9}, {}); }), "--depth-unit");
    EXPECT_CONTAINS(error_of([] { read_wide({9}, {.kind = DepthKind::inverse_depth}); }), "--depth-unit");
}

TEST(DepthReader, RefusalsSayWhatIsWrong) {
    const Folder folder;
    EXPECT_CONTAINS(error_of([&] {
                        read_depth_map(folder.write("a.jpg", make_jpeg(8, 8, Bytes(64), JpegKind::grey)), {});
                    }),
                    "does not keep depths exactly");
    EXPECT_CONTAINS(
        error_of([&] {
            read_depth_map(folder.write("c.png", make_png(1, 1, {1, 2, 3}, {.colour_type = 2})), {});
        }),
        "colour");
    EXPECT_CONTAINS(error_of([] { read_wide({0, 65535}); }), "no pixel of the map is known");
}

TEST(DepthReader, FaultsOfTheConfigurationAreNamed) {
    EXPECT_EQ(wrong_depth_config({}), "");
    for (const char* unit : {"cm", "-3", "0", "nan", "1e999", "m "})
        EXPECT_CONTAINS(wrong_depth_config({.unit = unit}), "input.depth.unit");
    EXPECT_CONTAINS(wrong_depth_config({.affine_scale = 0}), "affine_scale");
    EXPECT_CONTAINS(wrong_depth_config({.near_m = 3, .far_m = 2}), "near_m");
    EXPECT_CONTAINS(error_of([] { read_floats({1}, {.unit = "cm"}); }, ErrorKind::usage), "input.depth.unit");
}

}  // namespace
}  // namespace hexrelief::readers
