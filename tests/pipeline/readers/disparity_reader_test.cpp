#include "pipeline/readers/disparity_reader.h"

#include <cmath>
#include <limits>

#include "pipeline/readers/depth/depth_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

DisparityMap read(const Bytes& bytes, const DisparityFileConfig& config = {}) {
    const Folder folder;
    return read_disparity_map(folder.write("any.name", bytes), config);
}

std::string error_for(const Bytes& bytes, const DisparityFileConfig& config = {}) {
    return error_of_file("bad.map", bytes, [&](const auto& path) { read_disparity_map(path, config); });
}

using Values = std::vector<float>;

TEST(ReadDisparity, ScalesEightBits) {
    const DisparityMap map = read(make_pgm(3, 2, 255, {0, 4, 8, 10, 100, 255}), {.scale = 4});
    EXPECT_EQ(map.width, 3);
    EXPECT_EQ(map.height, 2);
    EXPECT_EQ(map.values, (Values{kInf, 1, 2, 2.5, 25, 63.75}));
    EXPECT_EQ(read(make_png(3, 1, {0, 4, 8}, {}), {.scale = 2, .offset_px = 10}).values,
              (Values{kInf, 12, 14}));
}

TEST(ReadDisparity, EightBitsWithoutScaleListsMiddleburysScales) {
    for (const Bytes& file : {make_pgm(2, 1, 255, {1, 2}), make_png(2, 1, {1, 2}, {}),
                              make_tiff(2, 1, {1, 2}, {}), make_png(2, 1, {0x12}, {.bits = 4})}) {
        const std::string message = error_for(file);
        for (const char* part :
             {"--disparity-scale", "input.disparity.scale", "2001 sets 8 (tsukuba 16)",
              "2003 quarter size 4, half 2, full 1", "2005/2006 third size 3, half 2, full 1"})
            EXPECT_CONTAINS(message, part);
    }
}

TEST(ReadDisparity, SixteenBitsAreKittis) {
    const auto wide = std::vector<std::uint16_t>{0, 256, 384, 65535};
    const Values expected{kInf, 1, 1.5, 65535 / 256.f};
    EXPECT_EQ(read(make_png(4, 1, {0, 0, 1, 0, 1, 128, 255, 255}, {.bits = 16})).values, expected);
    EXPECT_EQ(read(make_pgm(4, 1, 65535, {0, 0, 1, 0, 1, 128, 255, 255})).values, expected);
    EXPECT_EQ(read(make_tiff(4, 1, bytes_of(wide), {.bits = 16})).values, expected);
    EXPECT_EQ(read(make_tiff(4, 1, bytes_of(wide), {.bits = 16, .big_endian = true})).values, expected);
    EXPECT_EQ(read(make_png(2, 1, {0, 0, 1, 0}, {.bits = 16}), {.scale = 16}).values, (Values{kInf, 16}));
}

TEST(ReadDisparity, RawNumbersAreNotStretched) {
    EXPECT_EQ(read(make_pgm(3, 1, 100, {0, 50, 100}), {.scale = 1}).values, (Values{kInf, 50, 100}));
    EXPECT_EQ(read(make_png(4, 1, {0x12, 0x3f}, {.bits = 4}), {.scale = 1}).values, (Values{1, 2, 3, 15}));
    EXPECT_EQ(read(make_tiff(4, 1, {0x12, 0x3f}, {.bits = 4}), {.scale = 1}).values, (Values{1, 2, 3, 15}));
}

TEST(ReadDisparity, AnotherUnknownReplacesZero) {
    const Bytes file = make_pgm(3, 1, 255, {0, 4, 255});
    EXPECT_EQ(read(file, {.scale = 1, .offset_px = 1, .unknown = 255}).values, (Values{1, 5, kInf}));
    EXPECT_EQ(read(file, {.scale = 1, .unknown = 255}).values, (Values{kInf, 4, kInf}))
        << "0 px has no depth";
    EXPECT_EQ(read(file, {.scale = 1, .offset_px = -1, .unknown = 4, .beyond_px = -9}).values,
              (Values{-1, kInf, 254}));
}

TEST(ReadDisparity, SamplesBelowZeroAreDisparities) {
    const Bytes both = make_pfm(5, 1, {-41, 30, 0, -7.5f, kNan});
    EXPECT_EQ(read(both, {.offset_px = 50}).values, (Values{9, 80, 50, 42.5f, kInf}));
    EXPECT_EQ(read(both, {.beyond_px = -100}).values, (Values{-41, 30, 0, -7.5f, kInf}));
    EXPECT_EQ(read(both).values, (Values{kInf, 30, kInf, kInf, kInf}));
    EXPECT_EQ(read(both, {.scale = -1}).values, (Values{41, kInf, kInf, 7.5f, kInf}));
    EXPECT_EQ(read(both, {.offset_px = 50, .unknown = 30}).values, (Values{9, kInf, 50, 42.5f, kInf}));
    EXPECT_CONTAINS(error_for(make_pfm(2, 1, {-3, -4})), "-1 if the sign is turned");
}

TEST(ReadDisparity, ASingleValueBelowZeroIsUnknown) {
    EXPECT_EQ(read(make_pfm(4, 1, {-1, 3, 0, -1}), {.offset_px = 5}).values, (Values{kInf, 8, 5, kInf}));
    EXPECT_EQ(read(make_pfm(3, 1, {0, 3, 4}), {.offset_px = 5}).values, (Values{kInf, 8, 9}))
        << "0 is then not";
}

TEST(ReadDisparity, TheLeastValueIsUnknownIfItStandsAlone) {
    const DisparityFileConfig moved{.offset_px = 50};
    // StereoSGBM's in px, for a search from -16 px on.
    EXPECT_EQ(read(make_pfm(5, 1, {-17, -15.5f, 0, 4, -17}), moved).values,
              (Values{kInf, 34.5f, 50, 54, kInf}));
    EXPECT_EQ(read(make_pfm(4, 1, {-17, -16, 4, -17}), moved).values, (Values{33, 34, 54, 33}))
        << "as far apart as whole px";
    EXPECT_EQ(read(make_pfm(3, 1, {-17, -12, 4}), moved).values, (Values{33, 38, 54})) << "a single pixel";
}

TEST(ReadDisparity, SignedIntegersAndHalvesOfTiff) {
    const auto tiff = [](auto samples, int bits, int format) {
        return make_tiff(static_cast<int>(samples.size()), 1, bytes_of(samples),
                         {.bits = bits, .format = format});
    };
    const DisparityFileConfig moved{.scale = 1, .offset_px = 50};
    const Values expected{9, 80, 43};
    EXPECT_EQ(read(tiff(std::vector<std::int8_t>{-41, 30, -7}, 8, 2), moved).values, expected);
    EXPECT_EQ(read(tiff(std::vector<std::int16_t>{-41, 30, -7}, 16, 2), moved).values, expected);
    EXPECT_EQ(read(tiff(std::vector<std::int32_t>{-41, 30, -7}, 32, 2), moved).values, expected);
    EXPECT_EQ(read(tiff(std::vector<std::uint32_t>{70000, 0, 256}, 32, 1), {.scale = 256}).values,
              (Values{70000 / 256.f, kInf, 1}));
    EXPECT_EQ(read(tiff(std::vector<std::uint16_t>{0x3c00, 0x4000}, 16, 3)).values, (Values{1, 2}))
        << "halves";
    EXPECT_EQ(read(make_tiff(2, 1, bytes_of(std::vector<std::int16_t>{-32768, 5}),
                             {.bits = 16, .format = 2, .nodata = "-32768"}),
                   moved)
                  .values,
              (Values{kInf, 55}));
}

TEST(ReadDisparity, StereoSgbmIsKnownByItsTypeAndItsUnknown) {
    const Folder folder;
    const auto file_of = [&](const std::vector<std::int16_t>& samples,
                             const DisparityFileConfig& config = {}) {
        return read_disparity_file(
            folder.write("d.tiff", make_tiff(static_cast<int>(samples.size()), 1, bytes_of(samples),
                                             {.bits = 16, .format = 2})),
            config);
    };
    const DisparityFile file = file_of({-16, 0, 24, 160});
    EXPECT_EQ(file.map.values, (Values{kInf, kInf, 1.5f, 10}));
    EXPECT_EQ(file.believed, "signed 16-bit integers, 1/16 px as StereoSGBM's, -16 unknown");
    EXPECT_TRUE(file.is_scale_assumed);
    // The least disparity searched is -4 px.
    EXPECT_EQ(file_of({-80, -64, 24, -30}, {.beyond_px = -9}).map.values, (Values{kInf, -4, 1.5f, -1.875f}));
    EXPECT_FALSE(file_of({-16, 24}, {.scale = 16}).is_scale_assumed);
    EXPECT_EQ(file_of({-16, 24}, {.scale = 8}).map.values, (Values{kInf, 3}));
    EXPECT_CONTAINS(error_of([&] { file_of({-41, 30, -16}); }), "does not say how many are one pixel");
}

TEST(ReadDisparity, StereoSgbmIsKnownWithoutItsSign) {
    const Folder folder;
    const auto file_of = [&](const std::vector<std::uint16_t>& samples,
                             const DisparityFileConfig& config = {}) {
        return read_disparity_file(folder.write("d.tiff", make_tiff(static_cast<int>(samples.size()), 1,
                                                                    bytes_of(samples), {.bits = 16})),
                                   config);
    };
    const DisparityFile file = file_of({65520, 65520, 24, 160});
    EXPECT_EQ(file.map.values, (Values{kInf, kInf, 1.5f, 10}));
    EXPECT_EQ(file.believed,
              "16-bit integers that have lost their sign, 1/16 px as StereoSGBM's, -16 unknown");
    EXPECT_EQ(file_of({65520, 65520, 24}, {.scale = 16}).map.values, (Values{kInf, kInf, 1.5f}));
    // A search from -4 px on: -80 is unknown, -64 and -30 are known.
    EXPECT_EQ(file_of({65456, 65456, 65472, 24, 65506}, {.beyond_px = -9}).map.values,
              (Values{kInf, kInf, -4, 1.5f, -1.875f}));
    // KITTI's: near surfaces, one sample alone, a limit that is no multiple of 16.
    EXPECT_EQ(file_of({65520, 512, 40000, 40000}).map.values[1], 2);
    EXPECT_EQ(file_of({65520, 512, 600}).map.values[1], 2);
    EXPECT_EQ(file_of({65535, 65535, 512}).map.values[2], 2);
}

TEST(ReadDisparity, SaysWhatItAssumes) {
    const Folder folder;
    const auto said = [&](const Bytes& bytes, const DisparityFileConfig& config) {
        return read_disparity_file(folder.write("d", bytes), config).believed;
    };
    EXPECT_EQ(said(make_png(1, 1, {1, 0}, {.bits = 16}), {}), "16-bit integers, 1/256 px as KITTI's");
    EXPECT_EQ(said(make_png(1, 1, {1, 0}, {.bits = 16}), {.scale = 16}), "16-bit integers, 1/16 px");
    EXPECT_EQ(said(make_pfm(1, 1, {4}), {}), "floats, px");
    EXPECT_EQ(said(make_pfm(2, 1, {-4, -5}), {.scale = -1, .offset_px = 2.5}),
              "floats, px, sign turned, +2.5 px");
}

TEST(ReadDisparity, ColoursArePackedNumbers) {
    const Bytes picture = make_png(3, 1, {1, 64, 64, 0, 0, 0, 3, 128, 0}, {.colour_type = 2});
    EXPECT_EQ(read(picture, {.packing = Packing::sintel}).values, (Values{5.00390625f, kInf, 14}));
    EXPECT_CONTAINS(error_for(picture), "--packed carla, sintel or tartanair");
    EXPECT_CONTAINS(error_for(make_pfm(1, 1, {4}), {.packing = Packing::sintel}), "leave --packed out");
    const Folder folder;
    const Bytes carla = make_png(3, 1, {0, 0, 1, 255, 255, 255, 16, 39, 0}, {.colour_type = 2});
    const DepthFile depth = read_depth_map(folder.write("d.png", carla), {.packing = Packing::carla});
    EXPECT_FLOAT_EQ(depth.map.values[0], 65536 * 1000 / 16777215.f);
    EXPECT_EQ(depth.map.values[1], kInf) << "the sky";
    EXPECT_FLOAT_EQ(depth.map.values[2], 10000 * 1000 / 16777215.f);
    EXPECT_EQ(depth.believed, "CARLA's 24 bits, m");
    // 1 and 2.5 are 0x3f800000 and 0x40200000; alpha is the highest byte.
    const Bytes floats = make_png(2, 1, {0x80, 0, 0, 0x3f, 0x20, 0, 0, 0x40}, {.colour_type = 6});
    const auto file = folder.write("f.png", floats);
    EXPECT_EQ(read_depth_map(file, {.packing = Packing::tartanair}).map.values, (Values{1, 2.5f}));
    EXPECT_CONTAINS(error_of([&] { read_depth_map(file, {.packing = Packing::carla}); }),
                    "--packed tartanair");
    EXPECT_CONTAINS(error_for(picture, {.packing = Packing::tartanair}), "fourth channel");
}

TEST(ReadDisparity, RowsMayBeStoredInTheOtherOrder) {
    EXPECT_EQ(read(make_pfm(2, 3, {1, 2, 3, 4, 5, 6}), {.flip = true}).values, (Values{1, 2, 3, 4, 5, 6}));
    const Folder folder;
    EXPECT_EQ(read_depth_map(folder.write("d", make_pfm(2, 2, {1, 2, 3, 4})), {.flip = true}).map.values,
              (Values{1, 2, 3, 4}));
}

TEST(ReadDisparity, FilesOfOtherKindsAreNamed) {
    EXPECT_CONTAINS(error_for(to_bytes("\x89HDF\r\n\x1a\n........")), "it is HDF5");
    EXPECT_CONTAINS(error_for(to_bytes("MATLAB 5.0 MAT-file")), "MATLAB's .mat");
    EXPECT_CONTAINS(error_for(to_bytes("ply\nformat ascii 1.0\n")), "PLY");
    EXPECT_CONTAINS(error_for(to_bytes("\x80\4\x95.......")), "it is a Python pickle");
    using namespace std::string_literals;
    EXPECT_CONTAINS(error_for(to_bytes("\0\0\0\x1c"
                                       "ftypavif\0\0\0\0"s)),
                    "it is AVIF");
    EXPECT_CONTAINS(error_for(to_bytes("\0\0\0\x0cjP  \r\n\x87\n...."s)), "it is JPEG 2000");
}

TEST(ReadDisparity, PfmIsBottomRowFirstAndItsScaleOnlyASign) {
    const Values stored{5, 6, 7, 1, 2, 3}, expected{1, 2, 3, 5, 6, 7};
    EXPECT_EQ(read(make_pfm(3, 2, stored, true)).values, expected);
    EXPECT_EQ(read(make_pfm(3, 2, stored, false)).values, expected);
    EXPECT_EQ(read(make_pfm(3, 2, stored), {.scale = 2, .offset_px = 10}).values,
              (Values{10.5, 11, 11.5, 12.5, 13, 13.5}));
}

TEST(ReadDisparity, FloatsThatAreNoDisparityAreUnknown) {
    const Values raw{kNan, kInf, -kInf, 0, -3, 9, 5.5};
    EXPECT_EQ(read(make_pfm(7, 1, raw)).values, (Values{kInf, kInf, kInf, kInf, kInf, 9, 5.5}));
    EXPECT_EQ(read(make_pfm(7, 1, raw), {.unknown = 9}).values,
              (Values{kInf, kInf, kInf, kInf, kInf, kInf, 5.5}));
    EXPECT_EQ(read(make_tiff(7, 1, bytes_of(raw), {.bits = 32, .format = 3})).values,
              (Values{kInf, kInf, kInf, kInf, kInf, 9, 5.5}));
}

TEST(ReadDisparity, FloatTiffInEveryLayout) {
    Values raw;
    for (int i = 0; i < 37 * 21; ++i) raw.push_back(1 + 0.25f * static_cast<float>(i));
    for (int tile : {0, 16})
        for (bool big_endian : {false, true}) {
            const TiffKind kind{
                .bits = 32, .format = 3, .compression = 5, .tile = tile, .big_endian = big_endian};
            EXPECT_EQ(read(make_tiff(37, 21, bytes_of(raw), kind)).values, raw);
        }
    const std::vector<double> doubles(raw.begin(), raw.end());
    EXPECT_EQ(read(make_tiff(37, 21, bytes_of(doubles), {.bits = 64, .format = 3})).values, raw);
}

TEST(ReadDisparity, EqualChannelsAreGreyOthersAnError) {
    EXPECT_EQ(read(make_pgm(2, 1, 255, {3, 3, 3, 8, 8, 8}, '6'), {.scale = 1}).values, (Values{3, 8}));
    EXPECT_CONTAINS(error_for(make_pgm(2, 1, 255, {3, 3, 3, 8, 9, 8}, '6'), {.scale = 1}), "colour");
    const Bytes grey = make_pfm(3, 2, Values{7, 7, 7, kNan, kNan, kNan, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4});
    const Bytes header = to_bytes("PF\n3 2\n-1\n");
    const auto samples = [&](const Bytes& file) { return Bytes(file.end() - 72, file.end()); };
    EXPECT_EQ(read(header + samples(grey)).values, (Values{2, 3, 4, 7, kInf, 1}));
    Bytes colours = header + samples(grey);
    colours[colours.size() - 1] ^= 1;
    EXPECT_CONTAINS(error_for(colours), "colour");
}

TEST(ReadDisparity, RefusesTheWrongByteOrder) {
    Values values;
    for (int i = 0; i < 200; ++i) values.push_back(i % 3 ? 20 + 0.371f * static_cast<float>(i) : kInf);
    Bytes file = make_pfm(20, 10, values, true);
    EXPECT_NO_THROW(read(file));
    file[std::string("Pf\n20 10\n").size()] = ' ';  // the minus sign
    EXPECT_CONTAINS(error_for(file), "byte order");
    for (float& value : values) value = std::floor(value);  // byte-swapped integers are denormal
    file = make_pfm(20, 10, values, false);
    EXPECT_NO_THROW(read(file));
    const Bytes wrong = to_bytes("Pf\n20 10\n-1\n") + Bytes(file.end() - 800, file.end());
    EXPECT_CONTAINS(error_for(wrong), "byte order");
}

TEST(ReadDisparity, RefusesMalformedPfm) {
    const Bytes good = make_pfm(3, 2, {1, 2, 3, 4, 5, 6});
    EXPECT_CONTAINS(error_for(Bytes(good.begin(), good.end() - 1)), "truncated");
    EXPECT_CONTAINS(error_for(good + Bytes{1, 2, 3, 4}), "follow");
    EXPECT_NO_THROW(read(good + Bytes{'\n'}));
    EXPECT_CONTAINS(error_for(to_bytes("Pf\n3 2\n0\n")), "scale");
    EXPECT_CONTAINS(error_for(to_bytes("Pf\n3 2\nnan\n")), "scale");
    EXPECT_CONTAINS(error_for(to_bytes("Pf\n3 2\n")), "scale");
    EXPECT_CONTAINS(error_for(to_bytes("Pf\n0 2\n-1\n")), "0x2");
    EXPECT_CONTAINS(error_for(to_bytes("Pf\n-3 2\n-1\n")), "width");
    EXPECT_CONTAINS(error_for(to_bytes("Pf\n100000 100000\n-1\n")), "limit");
    EXPECT_CONTAINS(error_for(to_bytes("Pf\n20000 20000\n-1\n") + Bytes(64)), "truncated");
}

TEST(ReadDisparity, RefusesMapsWithNothingKnown) {
    EXPECT_CONTAINS(error_for(make_pgm(2, 1, 255, {0, 0}), {.scale = 1}), "known");
    EXPECT_CONTAINS(error_for(make_pfm(2, 1, {kNan, kInf})), "known");
}

TEST(ReadDisparity, RefusesFormatsThatKeepNoDisparity) {
    EXPECT_CONTAINS(error_for(make_jpeg(8, 8, Bytes(64, 9), JpegKind::grey), {.scale = 1}), "JPEG");
    EXPECT_CONTAINS(error_for(make_webp(1, 1, {1, 1, 1, 255}, true), {.scale = 1}), "WebP");
    EXPECT_CONTAINS(error_for(make_tiff(2, 1, Bytes(16), {.bits = 64, .format = 2})), "signed");
    EXPECT_CONTAINS(error_for(make_tiff(2, 1, Bytes(16), {.bits = 64, .format = 6})), "complex");
    EXPECT_CONTAINS(error_for(to_bytes("1 2 3\n4 5 6\n")), "text");
}

TEST(ReadDisparity, RefusesAnImpossibleConfig) {
    const Folder folder;
    const auto path = folder.write("map.pgm", make_pgm(2, 1, 255, {1, 2}));
    for (double scale : {-65537.0, std::nan(""), double(kInf)}) {
        const auto action = [&] { read_disparity_map(path, {.scale = scale}); };
        EXPECT_CONTAINS(error_of(action, ErrorKind::usage), "input.disparity.scale");
    }
    const auto action = [&] { read_disparity_map(path, {.scale = 1, .offset_px = std::nan("")}); };
    EXPECT_CONTAINS(error_of(action, ErrorKind::usage), "input.disparity.offset");
}

}  // namespace
}  // namespace hexrelief::readers
