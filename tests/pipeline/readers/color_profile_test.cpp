
#include <lcms2.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>

#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/sample_files.h"
#include "tests/pipeline/readers/sample_profiles.h"

namespace hexrelief::readers {
namespace {

constexpr int kWidth = 4, kHeight = 2;
const Bytes kColors = {200, 100, 50, 50,  100, 200, 128, 128, 128, 255, 255, 255,
                       0,   0,   0,  120, 160, 90,  90,  60,  140, 220, 210, 190};

double linear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double encoded(double light) {
    const double clipped = std::clamp(light, 0.0, 1.0);
    return clipped <= 0.0031308 ? clipped * 12.92 : 1.055 * std::pow(clipped, 1 / 2.4) - 0.055;
}

// Display P3 to sRGB by the matrix of their primaries (SMPTE EG 432-1, IEC 61966-2-1), both of white D65.
Bytes srgb_of_p3(const Bytes& colors) {
    constexpr double kMatrix[3][3] = {{1.2249401763, -0.2249401763, 0},
                                      {-0.0420569547, 1.0420569547, 0},
                                      {-0.0196375546, -0.0786360456, 1.0982736002}};
    Bytes converted;
    for (std::size_t i = 0; i < colors.size(); i += 3)
        for (const auto& row : kMatrix) {
            double light = 0;
            for (std::size_t c = 0; c < 3; ++c) light += row[c] * linear(colors[i + c] / 255.0);
            converted.push_back(static_cast<std::uint8_t>(std::lround(255 * encoded(light))));
        }
    return converted;
}

int largest_difference(const Bytes& a, const Bytes& b) {
    EXPECT_EQ(a.size(), b.size());
    int largest = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        largest = std::max(largest, std::abs(int(a[i]) - int(b[i])));
    return largest;
}

Bytes pixels_of(const Bytes& file) {
    const Folder folder;
    return read_image(folder.write("any.name", file)).pixels;
}

Bytes big_endian(std::size_t number) {
    Bytes bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(number >> shift));
    return bytes;
}
Bytes little_endian(std::size_t number, int count) {
    Bytes bytes;
    for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(number >> 8 * i));
    return bytes;
}

Bytes with_inserted(Bytes file, std::size_t at, const Bytes& inserted) {
    file.insert(file.begin() + static_cast<std::ptrdiff_t>(at), inserted.begin(), inserted.end());
    return file;
}

Bytes png_with(const Bytes& profile, const Bytes& rows = kColors, int colour_type = 2, int bits = 8) {
    uLongf size = compressBound(profile.size());
    Bytes packed(size);
    compress(packed.data(), &size, profile.data(), profile.size());
    packed.resize(size);
    const Bytes content = to_bytes(std::string_view("iCCPname\0\0", 10)) + packed;
    const Bytes chunk = big_endian(content.size() - 4) + content +
                        big_endian(crc32(0, content.data(), static_cast<uInt>(content.size())));
    constexpr std::size_t kBehindHeader = 33;
    return with_inserted(make_png(kWidth, kHeight, rows, {.bits = bits, .colour_type = colour_type}),
                         kBehindHeader, chunk);
}

Bytes jpeg_with(const Bytes& profile, const Bytes& samples, int side) {
    const Bytes content = to_bytes(std::string_view("ICC_PROFILE\0\1\1", 14)) + profile;
    const std::size_t length = content.size() + 2;
    const Bytes marker = {0xff, 0xe2, std::uint8_t(length >> 8), std::uint8_t(length)};
    return with_inserted(make_jpeg(side, side, samples, JpegKind::rgb), 2, marker + content);
}

Bytes webp_with(const Bytes& profile) {
    Bytes rgba;
    for (std::size_t i = 0; i < kColors.size(); i += 3)
        rgba.insert(rgba.end(), {kColors[i], kColors[i + 1], kColors[i + 2], 255});
    const Bytes simple = make_webp(kWidth, kHeight, rgba, true);
    const Bytes head = to_bytes("VP8X") + little_endian(10, 4) + Bytes{0x20, 0, 0, 0} +
                       little_endian(kWidth - 1, 3) + little_endian(kHeight - 1, 3);
    Bytes chunks = head + to_bytes("ICCP") + little_endian(profile.size(), 4) + profile +
                   Bytes(profile.size() % 2, 0) + Bytes(simple.begin() + 12, simple.end());
    return to_bytes("RIFF") + little_endian(chunks.size() + 4, 4) + to_bytes("WEBP") + chunks;
}

Bytes tiff_with(const Bytes& profile) {
    return make_tiff(kWidth, kHeight, kColors, {.samples = 3, .photometric = 2, .profile = profile});
}

TEST(ColorProfile, DisplayP3IsConvertedInEveryFormat) {
    const Bytes profile = display_p3_profile(), wanted = srgb_of_p3(kColors);
    EXPECT_GT(largest_difference(wanted, kColors), 15);  // the test can tell
    for (const Bytes& file : {png_with(profile), webp_with(profile), tiff_with(profile)})
        EXPECT_LE(largest_difference(pixels_of(file), wanted), 1);
    Bytes flat;
    for (int i = 0; i < 16 * 16; ++i) flat.insert(flat.end(), {200, 100, 50});
    const Bytes read = pixels_of(jpeg_with(profile, flat, 16));
    EXPECT_LE(largest_difference({read[0], read[1], read[2]}, srgb_of_p3({200, 100, 50})), 3);
}

TEST(ColorProfile, SrgbItselfChangesNothing) {
    const Bytes profile = saved_profile(cmsCreate_sRGBProfile());
    EXPECT_EQ(pixels_of(png_with(profile)), kColors);
    EXPECT_EQ(pixels_of(tiff_with(profile)), kColors);
}

TEST(ColorProfile, GreyFollowsItsCurve) {
    const Bytes profile = grey_profile(1.8);
    const Bytes greys = {0, 30, 60, 100, 128, 170, 220, 255};
    Bytes wanted;
    for (const std::uint8_t grey : greys)
        wanted.push_back(static_cast<std::uint8_t>(std::lround(255 * encoded(std::pow(grey / 255.0, 1.8)))));
    EXPECT_GT(largest_difference(wanted, greys), 10);
    EXPECT_LE(largest_difference(pixels_of(png_with(profile, greys, 0)), wanted), 1);
}

TEST(ColorProfile, MalformedOnesAndThoseOfOtherColoursAreIgnored) {
    Bytes damaged = display_p3_profile();
    damaged.resize(200);
    for (const Bytes& profile : {damaged, Bytes{1, 2, 3}, Bytes(300, 0xff)}) {
        EXPECT_EQ(pixels_of(tiff_with(profile)), kColors);
        EXPECT_EQ(pixels_of(webp_with(profile)), kColors);
    }
    EXPECT_EQ(pixels_of(tiff_with(grey_profile(1.8))), kColors);
}

TEST(ColorProfile, NumbersOfAMapStay) {
    const Bytes profile = grey_profile(1.8);
    const Bytes values = {1, 30, 60, 100, 128, 170, 220, 255};
    const Folder folder;
    DisparityFileConfig config{.scale = 1};
    const DisparityMap map =
        read_disparity_map(folder.write("map.png", png_with(profile, values, 0)), config);
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(map.values[i], values[i]);
}

}  // namespace
}  // namespace hexrelief::readers
