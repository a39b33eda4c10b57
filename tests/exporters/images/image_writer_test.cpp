#include "exporters/images/image_writer.h"

#include <png.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"
#include "tests/libjpeg.h"

namespace hexrelief::exporters {
namespace {

Image decode_png(const std::vector<std::uint8_t>& bytes, int channels) {
    png_image reader = {};
    reader.version = PNG_IMAGE_VERSION;
    EXPECT_TRUE(png_image_begin_read_from_memory(&reader, bytes.data(), bytes.size()));
    reader.format = channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
    Image out{static_cast<int>(reader.width), static_cast<int>(reader.height), channels, {}};
    out.pixels.resize(PNG_IMAGE_SIZE(reader));
    EXPECT_TRUE(png_image_finish_read(&reader, nullptr, out.pixels.data(), 0, nullptr)) << reader.message;
    return out;
}

class ImageWriter : public ::testing::TestWithParam<int> {};

TEST_P(ImageWriter, PngGivesTheSamePixels) {
    const Image image = sample_texture(37, 21, GetParam());
    const Image back = decode_png(encode_png(image), GetParam());
    EXPECT_EQ(back.width, 37);
    EXPECT_EQ(back.height, 21);
    EXPECT_EQ(back.pixels, image.pixels);
}

TEST_P(ImageWriter, JpegIsBaseline444AndClose) {
    const Image image = sample_texture(37, 21, GetParam());
    const test::DecodedJpeg back = test::decoded_by_libjpeg(encode_jpeg(image, 95));
    EXPECT_EQ(back.image.width, 37);
    EXPECT_EQ(back.image.height, 21);
    ASSERT_EQ(back.image.channels, GetParam());
    EXPECT_FALSE(back.progressive);
    EXPECT_EQ(back.largest_sampling, 1);
    double sum = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        sum += std::abs(image.pixels[i] - back.image.pixels[i]);
    EXPECT_LT(sum / static_cast<double>(image.pixels.size()), 3);
}

TEST_P(ImageWriter, OnePixel) {
    const Image image{1, 1, GetParam(), std::vector<std::uint8_t>(static_cast<std::size_t>(GetParam()), 77)};
    EXPECT_EQ(decode_png(encode_png(image), GetParam()).pixels, image.pixels);
    EXPECT_NEAR(test::decoded_by_libjpeg(encode_jpeg(image, 90)).image.pixels[0], 77, 2);
}

INSTANTIATE_TEST_SUITE_P(Channels, ImageWriter, ::testing::Values(1, 3));

TEST(ImageWriter, QualityDecidesSize) {
    const Image image = sample_texture(200, 150);
    EXPECT_LT(encode_jpeg(image, 30).size(), encode_jpeg(image, 95).size());
}

TEST(ImageWriter, SmoothBlocksKeepTheirLevel) {
    Image image{256 * 8, 8, 1, {}};
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) image.pixels.push_back(static_cast<std::uint8_t>(x / 8));
    const Image decoded = test::decoded_by_libjpeg(encode_jpeg(image, 30)).image;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        ASSERT_NEAR(decoded.pixels[i], image.pixels[i], 1) << i;
}

TEST(ImageWriter, TooWideForJpegIsErrorThatNamesPng) {
    const Image image{70000, 1, 1, std::vector<std::uint8_t>(70000, 1)};
    EXPECT_CONTAINS(test::error_of([&] { encode_jpeg(image, 90); }, ErrorKind::output), "PNG");
    EXPECT_EQ(decode_png(encode_png(image), 1).pixels, image.pixels);
}

TEST(ImageWriter, InconsistentImageIsBug) {
    EXPECT_THROW(encode_png({}), std::logic_error);
    EXPECT_THROW(encode_jpeg({2, 2, 3, std::vector<std::uint8_t>(11)}, 90), std::logic_error);
}

TEST(ImageWriter, WritesPngFile) {
    const TemporaryFolder folder;
    const Image image = sample_texture(9, 5);
    write_png(folder / "a.png", image);
    const std::string bytes = contents(folder / "a.png");
    EXPECT_EQ(decode_png({bytes.begin(), bytes.end()}, 3).pixels, image.pixels);
    EXPECT_THROW(write_png(folder / "missing/a.png", image), Error);
}

TEST(ImageWriter, ExrHasOneChannelOfFloatsTopRowFirst) {
    const std::vector<std::uint8_t> bytes = encode_exr(3, 2, {1, 2, 3, 4, 5, INFINITY});
    const std::string text(bytes.begin(), bytes.end());
    EXPECT_EQ(text.substr(0, 8), std::string("v/1\1\2\0\0\0", 8));
    // After the header: two offsets, then for each row its number, its bytes and its values.
    std::uint64_t rows[2];
    const std::size_t header = bytes.size() - sizeof rows - std::size_t{2} * (8 + 12);
    EXPECT_EQ(bytes[header - 1], 0);
    std::memcpy(rows, &bytes[header], sizeof rows);
    const float expected[2][3] = {{1, 2, 3}, {4, 5, INFINITY}};
    for (int y = 0; y < 2; ++y) {
        EXPECT_EQ(rows[y], header + sizeof rows + static_cast<std::size_t>(y) * 20);
        std::int32_t numbers[2];
        float values[3];
        std::memcpy(numbers, &bytes[rows[y]], 8);
        std::memcpy(values, &bytes[rows[y] + 8], 12);
        EXPECT_EQ(numbers[0], y);
        EXPECT_EQ(numbers[1], 12);
        for (int x = 0; x < 3; ++x) EXPECT_EQ(values[x], expected[y][x]);
    }
    EXPECT_THROW(encode_exr(3, 3, {1}), std::logic_error);
}

TEST(ImageWriter, PfmIsBottomRowFirstLittleEndian) {
    const TemporaryFolder folder;
    write_pfm(folder / "a.pfm", 3, 2, {1, 2, 3, 4, 5, INFINITY});
    const std::string bytes = contents(folder / "a.pfm");
    const std::string header = "Pf\n3 2\n-1.0\n";
    ASSERT_EQ(bytes.size(), header.size() + 24);
    EXPECT_EQ(bytes.substr(0, header.size()), header);
    float values[6];
    std::memcpy(values, bytes.data() + header.size(), 24);
    const float expected[6] = {4, 5, INFINITY, 1, 2, 3};
    for (int i = 0; i < 6; ++i) EXPECT_EQ(values[i], expected[i]);
    EXPECT_THROW(write_pfm(folder / "b.pfm", 3, 3, {1}), std::logic_error);
    EXPECT_EQ(folder.entries(), 1);
}

}  // namespace
}  // namespace hexrelief::exporters
