// Tests the maps that are a short header and floats.
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

Bytes floats(const std::vector<float>& samples) {
    return bytes_of(samples);
}

Bytes numbers(const std::vector<std::uint32_t>& values) {
    return bytes_of(values);
}

// A map of `width` x `height` pixels, of a picture of 64 x 48 px called "a", seen by one other view.
Bytes openmvs(std::uint32_t width, std::uint32_t height, const Bytes& samples, std::uint8_t kinds = 1) {
    return Bytes{'D', 'R', kinds, 0} + numbers({64, 48, width, height}) + Bytes(8) + Bytes{1, 0, 'a'} +
           numbers({2, 0, 1}) + Bytes(21 * 8) + samples;
}

Bytes sintel(std::uint32_t width, std::uint32_t height, const Bytes& samples) {
    return to_bytes("PIEH") + numbers({width, height}) + samples;
}

DepthFile depth_of(const Bytes& bytes, const DepthFileConfig& config = {}) {
    const Folder folder;
    return read_depth_map(folder.write("map", bytes), config);
}

std::string error_in(const Bytes& bytes) {
    const Folder folder;
    return error_of([&] { read_depth_map(folder.write("map", bytes), {}); });
}

TEST(FloatMaps, ColmapsDepthsAreInItsOwnUnits) {
    const Bytes bytes = to_bytes("3&2&1&") + floats({1, 2, 0, 4, 5, 6});
    const DepthFile file = depth_of(bytes);
    EXPECT_EQ(file.map.values, (std::vector<float>{1, 2, kInf, 4, 5, 6}));
    EXPECT_EQ(file.map.width, 3);
    EXPECT_FALSE(file.map.metric);
    EXPECT_EQ(file.believed, "COLMAP's depths, in units of the reconstruction");
    const DepthFile metric = depth_of(bytes, {.unit = "2"});
    EXPECT_TRUE(metric.map.metric);
    EXPECT_EQ(metric.map.values[1], 1);
    const Folder folder;
    EXPECT_CONTAINS(error_of([&] { read_disparity_map(folder.write("d", bytes), {}); }),
                    "give it by --depth");
    EXPECT_EQ(describe_raster(folder.write("d", bytes))->format, "colmap");
}

TEST(FloatMaps, OpenMvsDepthsStandBehindNamesAndCameras) {
    const DepthFile file = depth_of(openmvs(2, 2, floats({1, 2, 3, 4})));
    EXPECT_EQ(file.map.values, (std::vector<float>{1, 2, 3, 4}));
    EXPECT_FALSE(file.map.metric);
    EXPECT_EQ(depth_of(openmvs(2, 1, floats({1, 2}) + floats({9, 9, 9, 9, 9, 9}), 3)).map.values,
              (std::vector<float>{1, 2}))
        << "normals follow";
}

TEST(FloatMaps, SintelsDepthsAndFlow) {
    EXPECT_EQ(depth_of(sintel(2, 1, floats({1, 2}))).map.values, (std::vector<float>{1, 2}));
    EXPECT_TRUE(depth_of(sintel(2, 1, floats({1, 2}))).map.metric);
    const Folder folder;
    const auto flow = folder.write("a.flo", sintel(2, 1, floats({-5, 1, -7, 0})));
    EXPECT_EQ(read_disparity_map(flow, {.scale = -1}).values, (std::vector<float>{5, 7}));
}

TEST(FloatMaps, MalformedFilesAreRefused) {
    const std::vector<Bytes> good = {to_bytes("3&2&1&") + floats({1, 2, 0, 4, 5, 6}),
                                     openmvs(3, 2, floats({1, 2, 3, 4, 5, 6})),
                                     sintel(3, 2, floats({1, 2, 3, 4, 5, 6}))};
    for (const Bytes& bytes : good)
        for (std::size_t count = 16; count < bytes.size(); ++count)
            EXPECT_NE(error_in(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count))), "");
    EXPECT_CONTAINS(error_in(to_bytes("3&2&3&") + Bytes(72)), "normals");
    EXPECT_CONTAINS(error_in(to_bytes("3&2&1;") + Bytes(24)), "malformed COLMAP map");
    EXPECT_CONTAINS(error_in(to_bytes("0&2&1&") + Bytes(24)), "both sides must be at least 1");
    EXPECT_CONTAINS(error_in(to_bytes("99999&99999&1&") + Bytes(24)), "more than the limit");
    EXPECT_CONTAINS(error_in(to_bytes("3&2&1&") + Bytes(28)), "malformed: the header promises 24 bytes");
    EXPECT_CONTAINS(error_in(sintel(0x7fffffff, 0x7fffffff, Bytes(24))), "more than the limit");
    EXPECT_CONTAINS(error_in(to_bytes("3&2&1&") + floats(std::vector<float>(6, -kInf))), "no pixel");
    Bytes names = openmvs(3, 2, floats({1, 2, 3, 4, 5, 6}));
    names[28] = names[29] = 255;
    EXPECT_CONTAINS(error_in(names), "truncated");
}

}  // namespace
}  // namespace hexrelief::readers
