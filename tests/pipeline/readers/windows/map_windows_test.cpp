// Tests windows against crops of the maps that the readers of whole maps return.
#include "pipeline/readers/windows/map_windows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <thread>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

namespace fs = std::filesystem;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Returns floats that include all values that mean "unknown".
std::vector<float> sample_floats(int count) {
    const std::vector<float> unknown = {kNaN, kUnknownDisparity, -kUnknownDisparity, 0, -3, 2e6f, -9999};
    std::mt19937 random(7);
    std::vector<float> values(static_cast<std::size_t>(count));
    for (float& value : values)
        value = random() % 5 == 0 ? unknown[random() % unknown.size()]
                                  : static_cast<float>(random() % 100000) / 256 + 0.01f;
    return values;
}

template <typename Sample>
Bytes rows_of(const std::vector<float>& values) {
    std::vector<Sample> samples;
    for (const float value : values)
        samples.push_back(static_cast<Sample>(std::is_floating_point_v<Sample> ? value
                                              : std::isfinite(value)           ? std::abs(value)
                                                                               : 0));
    return bytes_of(samples);
}

Bytes rows_of(const std::vector<float>& values, const TiffKind& kind) {
    if (kind.format == 3) return kind.bits == 64 ? rows_of<double>(values) : rows_of<float>(values);
    return kind.bits == 16 ? rows_of<std::uint16_t>(values) : rows_of<std::uint8_t>(values);
}

void expect_crop(const DisparityMap& window, const DisparityMap& map, int x, int y) {
    ASSERT_EQ(window.values.size(), static_cast<std::size_t>(window.width) * window.height);
    for (int row = 0; row < window.height; ++row)
        for (int column = 0; column < window.width; ++column)
            ASSERT_EQ(window.at(column, row), map.at(x + column, y + row)) << x + column << "," << y + row;
}

// Checks the whole map, its corners, and windows anywhere.
void expect_windows(const fs::path& path, const MapWindowConfig& config, const DisparityMap& map) {
    const auto windows = MapWindows::open(path, config);
    ASSERT_EQ(windows->width(), map.width);
    ASSERT_EQ(windows->height(), map.height);
    expect_crop(windows->read(0, 0, map.width, map.height), map, 0, 0);
    expect_crop(windows->read(map.width - 1, map.height - 1, 1, 1), map, map.width - 1, map.height - 1);
    std::mt19937 random(11);
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    for (int i = 0; i < 12; ++i) {
        const int x = below(map.width), y = below(map.height);
        expect_crop(windows->read(x, y, 1 + below(map.width - x), 1 + below(map.height - y)), map, x, y);
    }
}

TEST(MapWindows, OfTiffsAreCropsOfTheWholeMap) {
    const Folder folder;
    const int width = 53, height = 39;
    const std::vector<float> values = sample_floats(width * height);
    for (const auto& [bits, format] : std::vector<std::pair<int, int>>{{8, 1}, {16, 1}, {32, 3}, {64, 3}})
        for (const int tile : {0, 16, 64})
            for (const int compression : {1, 5, 8})
                for (const int kind_number : {0, 1, 2}) {
                    TiffKind kind{.bits = bits,
                                  .format = format,
                                  .photometric = kind_number == 2 && format == 1 ? 0 : 1,
                                  .compression = compression,
                                  .tile = tile,
                                  .big_endian = kind_number == 1,
                                  .nodata = kind_number == 2 ? (format == 3 ? "-9999" : "17") : ""};
                    SCOPED_TRACE(std::to_string(bits) + " bits, tile " + std::to_string(tile) +
                                 ", compression " + std::to_string(compression) + ", kind " +
                                 std::to_string(kind_number));
                    const fs::path path =
                        folder.write("map.tif", make_tiff(width, height, rows_of(values, kind), kind));
                    const MapWindowConfig config{.disparity = {.scale = 3, .offset_px = -1}};
                    expect_windows(path, config, read_disparity_map(path, config.disparity));
                }
}

TEST(MapWindows, OfSamplesOfFewBits) {
    const Folder folder;
    for (const int bits : {1, 2, 4}) {
        const int width = 51, height = 9;
        Bytes rows(static_cast<std::size_t>((width * bits + 7) / 8) * height);
        std::mt19937 random(3);
        for (std::uint8_t& byte : rows) byte = static_cast<std::uint8_t>(random());
        TiffKind kind{.bits = bits};
        const fs::path path = folder.write("map.tif", make_tiff(width, height, rows, kind));
        expect_windows(path, {.disparity = {.scale = 1}}, read_disparity_map(path, {.scale = 1}));
    }
}

TEST(MapWindows, OfPfmsOfEitherByteOrder) {
    const Folder folder;
    const std::vector<float> values = sample_floats(37 * 23);
    for (const bool little : {true, false}) {
        const fs::path path = folder.write("map.pfm", make_pfm(37, 23, values, little));
        expect_windows(path, {}, read_disparity_map(path, {}));
        expect_windows(path, {.disparity = {.scale = 2, .unknown = 5}},
                       read_disparity_map(path, {.scale = 2, .unknown = 5}));
    }
    const fs::path windows_text = folder.write(
        "text.pfm", to_bytes("Pf # a comment\n1 2\r\n-1\r\n") + bytes_of(std::vector<float>{1, 2}));
    expect_windows(windows_text, {}, read_disparity_map(windows_text, {}));
}

TEST(MapWindows, OfRawRows) {
    const Folder folder;
    std::vector<float> values = sample_floats(41 * 13), flipped;
    for (int y = 12; y >= 0; --y) flipped.insert(flipped.end(), &values[y * 41], &values[y * 41] + 41);
    const DisparityMap floats = read_disparity_map(folder.write("map.pfm", make_pfm(41, 13, flipped)), {});
    expect_windows(folder.write("map.raw", bytes_of(values)), {.raw = parse_raw_map_layout("41x13,float32")},
                   floats);
    for (float& value : values) {
        const Bytes bytes = bytes_of(std::vector<float>{value});
        const Bytes reversed(bytes.rbegin(), bytes.rend());
        std::memcpy(&value, reversed.data(), sizeof value);
    }
    const fs::path other = folder.write("map.raw", bytes_of(values));
    expect_windows(other, {.raw = parse_raw_map_layout("41x13,float32be")}, floats);
    EXPECT_CONTAINS(
        error_of([&] { MapWindows::open(other, {.raw = parse_raw_map_layout("41x13,float32")}); }),
        "float32be");

    std::vector<std::uint16_t> whole;
    for (int i = 0; i < 41 * 13; ++i) whole.push_back(static_cast<std::uint16_t>(i * 37));
    TiffKind kind{.bits = 16};
    const DisparityMap kitti =
        read_disparity_map(folder.write("map.tif", make_tiff(41, 13, bytes_of(whole), kind)), {});
    expect_windows(folder.write("map.raw", bytes_of(whole)), {.raw = parse_raw_map_layout("41x13,uint16")},
                   kitti);
    for (std::uint16_t& value : whole) value = static_cast<std::uint16_t>(value >> 8 | value << 8);
    expect_windows(folder.write("map.raw", bytes_of(whole)), {.raw = parse_raw_map_layout("41x13,uint16be")},
                   kitti);
}

TEST(MapWindows, MayHaveNoKnownPixel) {
    const Folder folder;
    std::vector<float> values(64, kNaN);
    values[0] = 5;
    const auto windows = MapWindows::open(folder.write("map.pfm", make_pfm(8, 8, values)));
    const DisparityMap window = windows->read(0, 0, 8, 7);
    EXPECT_EQ(window.values, std::vector<float>(56, kUnknownDisparity));
    EXPECT_EQ(windows->read(0, 7, 1, 1).values, std::vector<float>{5});
}

TEST(MapWindows, ServeSeveralThreads) {
    const Folder folder;
    const int width = 150, height = 130;
    const std::vector<float> values = sample_floats(width * height);
    TiffKind kind{.bits = 32, .format = 3};
    kind.tile = 16;
    kind.compression = 8;
    for (const fs::path& path : {folder.write("tiles.tif", make_tiff(width, height, bytes_of(values), kind)),
                                 folder.write("map.pfm", make_pfm(width, height, values))}) {
        const DisparityMap map = read_disparity_map(path, {});
        const auto windows = MapWindows::open(path);
        std::vector<int> wrong(4, 0);
        std::vector<std::thread> threads;
        for (unsigned thread = 0; thread < 4; ++thread)
            threads.emplace_back([&, thread] {
                std::mt19937 random(thread);
                for (int i = 0; i < 50; ++i) {
                    const int x = static_cast<int>(random() % 100), y = static_cast<int>(random() % 100);
                    const DisparityMap window = windows->read(x, y, 50, 30);
                    for (int row = 0; row < 30; ++row)
                        for (int column = 0; column < 50; ++column)
                            wrong[thread] += window.at(column, row) != map.at(x + column, y + row);
                }
            });
        for (std::thread& thread : threads) thread.join();
        EXPECT_EQ(wrong, std::vector<int>(4, 0));
    }
}

TEST(MapWindows, OutsideOfTheMapAreRefused) {
    const Folder folder;
    const auto windows =
        MapWindows::open(folder.write("map.pfm", make_pfm(3, 2, std::vector<float>(6, 1.0f))));
    constexpr int kMost = std::numeric_limits<int>::max();
    for (const auto& w : std::vector<std::array<int, 4>>{{0, 0, 4, 1},
                                                         {0, 0, 1, 3},
                                                         {-1, 0, 1, 1},
                                                         {0, -1, 1, 1},
                                                         {0, 0, 0, 1},
                                                         {0, 0, 1, -1},
                                                         {3, 0, 1, 1},
                                                         {1, 0, kMost, 1},
                                                         {kMost, 0, kMost, 1}})
        EXPECT_CONTAINS(error_of([&] { windows->read(w[0], w[1], w[2], w[3]); }), "there is no window");
}

TEST(MapWindows, DamagedFilesAreRefused) {
    const Folder folder;
    const auto open_error = [&](const Bytes& bytes, const MapWindowConfig& config = {}) {
        return error_of([&] { MapWindows::open(folder.write("bad", bytes), config); });
    };
    const auto read_error = [&](const Bytes& bytes) {
        const auto windows = MapWindows::open(folder.write("bad", bytes));
        return error_of([&] { windows->read(0, 0, windows->width(), windows->height()); });
    };
    EXPECT_CONTAINS(error_of([&] { MapWindows::open(folder.path() / "none"); }), "no such file");
    EXPECT_CONTAINS(error_of([&] { MapWindows::open(folder.path()); }), "folder");
    EXPECT_CONTAINS(open_error({}), "empty");
    EXPECT_CONTAINS(open_error(make_pgm(1, 1, 255, {1})), "cannot be read in windows");
    EXPECT_CONTAINS(open_error(to_bytes("Pf\n99999999 4\n-1\n")), "px a side");
    EXPECT_CONTAINS(open_error(to_bytes("Pf\n4000000 4000000\n-1\n")), "truncated");
    EXPECT_CONTAINS(open_error(to_bytes("Pf\n0 4\n-1\n")), "at least 1");
    EXPECT_CONTAINS(open_error(make_pfm(2, 2, {1, 2, 3, 4}) + Bytes(7, 0)), "7 bytes follow");
    EXPECT_CONTAINS(open_error(to_bytes("PF\n1 1\n-1\n") + Bytes(12, 0)), "three channels");
    EXPECT_CONTAINS(open_error(make_pfm(2, 1, {1, 2}, true), {.raw = parse_raw_map_layout("2x2,float32")}),
                    "16; correct the size");

    Bytes swapped = make_pfm(1, 4, {1, 2, 3, 4}, false);
    swapped.insert(std::find(swapped.begin(), swapped.end(), '\n') + 5, '-');
    EXPECT_CONTAINS(open_error(swapped), "other byte order");

    TiffKind kind{.bits = 8};
    const Bytes grey(64 * 64, 9);
    EXPECT_CONTAINS(open_error(make_tiff(64, 64, grey, kind)), "--disparity-scale");
    kind.bits = 16;
    const Bytes wide(2 * 64 * 64, 9);
    for (const int tile : {0, 16})
        for (const int compression : {1, 8}) {
            kind.tile = tile;
            kind.compression = compression;
            const Bytes whole = make_tiff(64, 64, wide, kind);
            EXPECT_CONTAINS(open_error(Bytes(whole.begin(), whole.begin() + whole.size() / 2)), "malformed");
        }
    kind.format = 2;
    EXPECT_CONTAINS(open_error(make_tiff(64, 64, wide, kind)), "signed");
    EXPECT_CONTAINS(open_error(make_tiff(8, 8, Bytes(3 * 64, 9), {.samples = 3, .photometric = 2})),
                    "3 samples a pixel");

    // A compressed tile with other contents.
    kind = {.bits = 16, .compression = 8, .tile = 16};
    Bytes lying = make_tiff(16, 16, Bytes(512, 9), kind);
    std::fill_n(lying.begin() + 8, 12, 0xff);
    EXPECT_CONTAINS(read_error(lying), "malformed");
}

// Files whose ends are cut off after they have been opened.
TEST(MapWindows, FilesThatShrinkAreRefused) {
    const Folder folder;
    const fs::path path = folder.write("map.raw", Bytes(400, 1));
    const auto windows = MapWindows::open(path, {.raw = parse_raw_map_layout("10x10,float32")});
    fs::resize_file(path, 200);
    EXPECT_NO_THROW(windows->read(0, 0, 10, 5));
    EXPECT_CONTAINS(error_of([&] { windows->read(0, 0, 10, 6); }), "ends within row 5");
}

TEST(RawMapLayout, IsParsedOrRefused) {
    const RawMapLayout layout = parse_raw_map_layout("32768x8,uint16be");
    EXPECT_EQ(layout.width, 32768);
    EXPECT_EQ(layout.height, 8);
    EXPECT_EQ(layout.sample, MapSample::uint16);
    EXPECT_TRUE(layout.is_big_endian);
    for (const char* const text :
         {"", "x", "3", "3x4", "3x4,", "3x4,float64", "3x4,float32bebe", "3 x4,uint16", "3x4,uint16 ",
          "0x4,uint16", "3x-4,uint16", "99999999x1,uint16", "99999999999999x1,uint16", "3x4,uint16\n"})
        EXPECT_NE(error_of([&] { parse_raw_map_layout(text); }, ErrorKind::usage), "") << text;
}

}  // namespace
}  // namespace hexrelief::readers
