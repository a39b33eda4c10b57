#include "pipeline/readers/image_reader.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

Image read(const Bytes& bytes) {
    const Folder folder;
    return read_image(folder.write("any.name", bytes));
}

std::string error_for(const Bytes& bytes) {
    return error_of_file("bad.bin", bytes, [](const auto& path) { read_image(path); });
}

void expect_image(const Image& image, int width, int height, int channels, const Bytes& pixels) {
    EXPECT_EQ(image.width, width);
    EXPECT_EQ(image.height, height);
    EXPECT_EQ(image.channels, channels);
    EXPECT_EQ(image.pixels, pixels);
}

const Bytes kGrey = {0, 50, 100, 150, 200, 255};                                               // 3 x 2
const Bytes kColour = {1, 2, 3, 40, 50, 60, 7, 8, 9, 100, 110, 120, 13, 14, 15, 255, 0, 128};  // 3 x 2

Bytes gradient(int width, int height, int channels) {
    Bytes samples;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c)
                samples.push_back(static_cast<std::uint8_t>(60 + 3 * x + 2 * y + 20 * c));
    return samples;
}

int largest_difference(const Bytes& a, const Bytes& b) {
    int largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(int(a[i]) - int(b[i])));
    return a.size() == b.size() ? largest : 999;
}

TEST(ReadPng, GivesGreyAndColourAsStored) {
    expect_image(read(make_png(3, 2, kGrey, {})), 3, 2, 1, kGrey);
    expect_image(read(make_png(3, 2, kColour, {.colour_type = 2})), 3, 2, 3, kColour);
}

TEST(ReadPng, InterlacedIsTheSame) {
    const Bytes large = gradient(19, 13, 3);
    expect_image(read(make_png(19, 13, large, {.colour_type = 2, .interlaced = true})), 19, 13, 3, large);
}

TEST(ReadPng, RoundsSixteenBits) {
    // big endian 0, 128, 129, 385, 386, 65535: v * 255 / 65535 = 0, .498, .502, 1.498, 1.502, 255
    const Bytes rows = {0, 0, 0, 128, 0, 129, 1, 129, 1, 130, 255, 255};
    expect_image(read(make_png(3, 2, rows, {.bits = 16})), 3, 2, 1, {0, 0, 1, 1, 2, 255});
}

TEST(ReadPng, AlphaDarkensNothingAndIsKeptWhereAPixelIsTransparent) {
    const Image grey = read(make_png(2, 1, {10, 0, 20, 128}, {.colour_type = 4}));
    expect_image(grey, 2, 1, 1, {10, 20});
    EXPECT_EQ(grey.alpha, (Bytes{0, 128}));
    const Image colour = read(make_png(2, 1, {1, 2, 3, 0, 4, 5, 6, 9}, {.colour_type = 6}));
    expect_image(colour, 2, 1, 3, {1, 2, 3, 4, 5, 6});
    EXPECT_EQ(colour.alpha, (Bytes{0, 9}));
    EXPECT_EQ(read(make_png(2, 1, {0, 1, 127, 255, 0, 2, 255, 0}, {.bits = 16, .colour_type = 4})).alpha,
              (Bytes{127, 255}));
    const Image opaque = read(make_png(2, 1, {1, 2, 3, 128, 4, 5, 6, 255}, {.colour_type = 6}));
    expect_image(opaque, 2, 1, 3, {1, 2, 3, 4, 5, 6});
    EXPECT_TRUE(opaque.alpha.empty());
}

TEST(ReadPng, ExpandsPalettesAndFewBits) {
    // Two bits per pixel: 0 1 2 3.
    const PngKind palette{.bits = 2,
                          .colour_type = 3,
                          .palette = {9, 8, 7, 1, 2, 3, 4, 5, 6, 250, 251, 252},
                          .palette_alpha = {0, 128}};
    expect_image(read(make_png(4, 1, {0x1b}, palette)), 4, 1, 3, {9, 8, 7, 1, 2, 3, 4, 5, 6, 250, 251, 252});
    EXPECT_EQ(read(make_png(4, 1, {0x1b}, palette)).alpha, (Bytes{0, 128, 255, 255}));
    expect_image(read(make_png(4, 1, {0x1b}, {.bits = 2})), 4, 1, 1, {0, 85, 170, 255});
    expect_image(read(make_png(8, 1, {0xa5}, {.bits = 1})), 8, 1, 1, {255, 0, 255, 0, 0, 255, 0, 255});
}

TEST(ReadPng, RefusesTruncatedFiles) {
    const Bytes whole = make_png(40, 30, gradient(40, 30, 3), {.colour_type = 2});
    for (std::size_t length = 8; length < whole.size(); length += 7)
        EXPECT_CONTAINS(error_for(Bytes(whole.begin(), whole.begin() + length)), "malformed PNG");
}

// Returns a PNG that has only its header chunk (with the correct checksum) and an empty IDAT.
Bytes png_header_only(std::uint32_t width, std::uint32_t height) {
    Bytes header = {0, 0, 0, 13, 'I', 'H', 'D', 'R'};
    for (std::uint32_t side : {width, height})
        for (int shift = 24; shift >= 0; shift -= 8)
            header.push_back(static_cast<std::uint8_t>(side >> shift));
    for (std::uint8_t b : {8, 2, 0, 0, 0}) header.push_back(b);
    std::uint32_t crc = 0xffffffff;
    for (std::size_t i = 4; i < header.size(); ++i) {
        crc ^= header[i];
        for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
    }
    crc = ~crc;
    for (int shift = 24; shift >= 0; shift -= 8) header.push_back(static_cast<std::uint8_t>(crc >> shift));
    return to_bytes("\x89PNG\r\n\x1a\n") + header +
           Bytes{0, 0, 0, 0, 'I', 'D', 'A', 'T', 0x35, 0xaf, 0x06, 0x1e};
}

TEST(ReadPng, RefusesHugeAndZeroSizesBeforeAllocating) {
    EXPECT_CONTAINS(error_for(png_header_only(0x7fffffff, 0x7fffffff)), "limit");
    EXPECT_CONTAINS(error_for(png_header_only(20000, 20000)),
                    "truncated");  // within the limit, but not within the file
    EXPECT_CONTAINS(error_for(png_header_only(0, 5)), "malformed PNG");
}

TEST(ReadPnm, GivesGreyAndColour) {
    expect_image(read(make_pgm(3, 2, 255, kGrey)), 3, 2, 1, kGrey);
    expect_image(read(make_pgm(3, 2, 255, kColour, '6')), 3, 2, 3, kColour);
}

TEST(ReadPnm, SkipsCommentsAndAnyWhiteSpace) {
    const Bytes header = to_bytes("P5 # made by hand\n#another\r\n\t3\n# between\n2# behind\n 255\n");
    expect_image(read(header + kGrey), 3, 2, 1, kGrey);
}

TEST(ReadPnm, TakesCrLfAfterTheHeaderForOneEnd) {
    expect_image(read(to_bytes("P5\r\n3 2\r\n255\r\n") + kGrey), 3, 2, 1, kGrey);
}

TEST(ReadPnm, StretchesOtherMaxvals) {
    expect_image(read(make_pgm(3, 1, 15, {0, 5, 15})), 3, 1, 1, {0, 85, 255});
    expect_image(read(make_pgm(3, 1, 1023, {0, 0, 1, 0, 3, 255})), 3, 1, 1, {0, 64, 255});  // big endian
    expect_image(read(make_pgm(2, 1, 65535, {255, 255, 1, 129})), 2, 1, 1, {255, 1});
}

TEST(ReadPnm, RefusesMalformedFiles) {
    EXPECT_CONTAINS(error_for(make_pgm(3, 2, 255, {1, 2, 3, 4, 5})), "truncated");
    EXPECT_CONTAINS(error_for(make_pgm(3, 2, 256, kGrey)), "truncated");
    EXPECT_CONTAINS(error_for(make_pgm(0, 2, 255, {})), "0x2");
    EXPECT_CONTAINS(error_for(make_pgm(3, 2, 0, kGrey)), "maxval");
    EXPECT_CONTAINS(error_for(make_pgm(3, 2, 65536, kGrey)), "maxval");
    EXPECT_CONTAINS(error_for(make_pgm(-3, 2, 255, kGrey)), "width");
    EXPECT_CONTAINS(error_for(to_bytes("P5 99999999999 1 255\n")), "width");
    EXPECT_CONTAINS(error_for(make_pgm(999999999, 999999999, 255, {})), "limit");
    EXPECT_CONTAINS(error_for(make_pgm(23170, 23170, 255, kGrey)), "truncated");
    EXPECT_CONTAINS(error_for(to_bytes("P5 three two 255\n")), "'three'");
    EXPECT_CONTAINS(error_for(to_bytes("P5 3 2 255")), "header");
    EXPECT_CONTAINS(error_for(to_bytes("P5\n")), "width");
}

TEST(ReadPnm, NamesTheKindsThatAreNotRead) {
    EXPECT_CONTAINS(error_for(to_bytes("P2\n1 1\n255\n7\n")), "P2");
    EXPECT_CONTAINS(error_for(to_bytes("P4\n8 1\n\xff")), "P4");
}

TEST(ReadJpeg, GivesGreyAndColour) {
    const Bytes grey = gradient(32, 17, 1), colour = gradient(32, 17, 3);
    const Image one = read(make_jpeg(32, 17, grey, JpegKind::grey));
    EXPECT_EQ(one.channels, 1);
    EXPECT_LE(largest_difference(one.pixels, grey), 3);
    for (JpegKind kind : {JpegKind::rgb, JpegKind::rgb_progressive}) {
        const Image three = read(make_jpeg(32, 17, colour, kind));
        EXPECT_EQ(three.width, 32);
        EXPECT_EQ(three.height, 17);
        EXPECT_EQ(three.channels, 3);
        EXPECT_LE(largest_difference(three.pixels, colour), 6);
    }
}

TEST(ReadJpeg, ConvertsInks) {
    Bytes inks;  // inverted, as Adobe writes them: 255 is no ink
    for (int i = 0; i < 64; ++i) inks = std::move(inks) + Bytes{255, 128, 0, 200};
    const Image image = read(make_jpeg(8, 8, inks, JpegKind::cmyk));
    ASSERT_EQ(image.channels, 3);
    ASSERT_EQ(image.pixels.size(), 192u);
    EXPECT_NEAR(image.pixels[0], 200, 3);
    EXPECT_NEAR(image.pixels[1], 100, 3);
    EXPECT_NEAR(image.pixels[2], 0, 3);
}

TEST(ReadJpeg, RefusesTruncatedFiles) {
    const Bytes whole = make_jpeg(64, 48, gradient(64, 48, 3), JpegKind::rgb);
    for (std::size_t length = 4; length < whole.size(); length += 11)
        EXPECT_CONTAINS(error_for(Bytes(whole.begin(), whole.begin() + length)), "malformed JPEG");
}

TEST(ReadJpeg, RefusesHugeHeadersBeforeAllocating) {
    Bytes file = make_jpeg(64, 48, gradient(64, 48, 3), JpegKind::rgb);
    const Bytes start_of_frame = {0xff, 0xc0, 0, 17, 8};
    const auto frame = std::search(file.begin(), file.end(), start_of_frame.begin(), start_of_frame.end());
    ASSERT_NE(frame, file.end());
    std::fill_n(frame + 5, 4, std::uint8_t{0xfa});
    EXPECT_CONTAINS(error_for(file), "limit");
    frame[5] = 0x4e, frame[7] = 0x4e;  // 20218 x 20218: within the limit, but not within the file
    EXPECT_CONTAINS(error_for(file), "truncated");
}

TEST(ReadWebp, GivesColourWithoutAlpha) {
    Bytes rgba;
    for (std::size_t i = 0; i < kColour.size(); i += 3)
        rgba = std::move(rgba) + Bytes{kColour[i], kColour[i + 1], kColour[i + 2], 255};
    EXPECT_TRUE(read(make_webp(3, 2, rgba, true)).alpha.empty());
    const Bytes lossy = read(make_webp(3, 2, rgba, false)).pixels;
    rgba[3] = 100;
    const Image image = read(make_webp(3, 2, rgba, true));
    expect_image(image, 3, 2, 3, kColour);
    EXPECT_EQ(image.alpha, (Bytes{100, 255, 255, 255, 255, 255}));
    expect_image(read(make_webp(3, 2, rgba, false)), 3, 2, 3, lossy);
}

TEST(ReadWebp, RefusesTruncatedFiles) {
    const Bytes whole = make_webp(40, 30, gradient(40, 30, 4), true);
    for (std::size_t length = 12; length + 2 < whole.size(); length += 5)
        EXPECT_CONTAINS(error_for(Bytes(whole.begin(), whole.begin() + length)), "WebP");
}

TEST(ReadTiff, GivesGreyAndColourHoweverStored) {
    const Bytes large = gradient(37, 21, 3);
    Bytes planar;
    for (int c = 0; c < 3; ++c)
        for (std::size_t i = c; i < large.size(); i += 3) planar.push_back(large[i]);
    expect_image(read(make_tiff(3, 2, kGrey, {})), 3, 2, 1, kGrey);
    for (int compression : {1, 5, 8})
        for (int tile : {0, 16})
            for (bool big_endian : {false, true}) {
                const TiffKind kind{.samples = 3,
                                    .photometric = 2,
                                    .compression = compression,
                                    .tile = tile,
                                    .big_endian = big_endian};
                expect_image(read(make_tiff(37, 21, large, kind)), 37, 21, 3, large);
                TiffKind planes = kind;
                planes.planes = true;
                expect_image(read(make_tiff(37, 21, planar, planes)), 37, 21, 3, large);
            }
}

TEST(ReadTiff, KeepsAlphaInvertsWhiteIsZeroAndRounds) {
    const Image colour = read(make_tiff(2, 1, {1, 2, 3, 0, 4, 5, 6, 9}, {.samples = 4, .photometric = 2}));
    expect_image(colour, 2, 1, 3, {1, 2, 3, 4, 5, 6});
    EXPECT_EQ(colour.alpha, (Bytes{0, 9}));
    const Image planes =
        read(make_tiff(2, 1, {1, 4, 2, 5, 3, 6, 0, 200}, {.samples = 4, .photometric = 2, .planes = true}));
    expect_image(planes, 2, 1, 3, {1, 2, 3, 4, 5, 6});
    EXPECT_EQ(planes.alpha, (Bytes{0, 200}));
    expect_image(read(make_tiff(3, 2, kGrey, {.photometric = 0})), 3, 2, 1, {255, 205, 155, 105, 55, 0});
    const auto wide = bytes_of(std::vector<std::uint16_t>{0, 128, 129, 385, 386, 65535});
    expect_image(read(make_tiff(3, 2, wide, {.bits = 16})), 3, 2, 1, {0, 0, 1, 1, 2, 255});
    expect_image(read(make_tiff(3, 2, wide, {.bits = 16, .big_endian = true})), 3, 2, 1,
                 {0, 0, 1, 1, 2, 255});
    expect_image(read(make_tiff(4, 1, {0x0f, 0x5a}, {.bits = 4})), 4, 1, 1, {0, 255, 85, 170});
}

TEST(ReadTiff, ExpandsPalettesAndIgnoresOrientation) {
    for (int orientation : {1, 3, 4}) {
        expect_image(read(make_tiff(2, 2, {0, 1, 2, 255}, {.photometric = 3, .orientation = orientation})), 2,
                     2, 3, {0, 255, 7, 1, 254, 7, 2, 253, 7, 255, 0, 7});
        expect_image(read(make_tiff(3, 2, kGrey, {.orientation = orientation})), 3, 2, 1, kGrey);
    }
}

TEST(ReadTiff, RefusesWhatIsNoPicture) {
    EXPECT_CONTAINS(error_for(make_tiff(2, 1, bytes_of(std::vector<float>{1, 2}), {.bits = 32, .format = 3})),
                    "float");
    EXPECT_CONTAINS(error_for(make_tiff(2, 1, {1, 2}, {.format = 2})), "signed");
}

TEST(ReadTiff, FloatColoursAreOfZeroToOne) {
    const auto of = [](const std::vector<float>& colors) {
        return make_tiff(2, 1, bytes_of(colors), {.samples = 3, .bits = 32, .format = 3, .photometric = 2});
    };
    expect_image(read(of({0, 0.5f, 1, 0.1f, -3, 7})), 2, 1, 3, {0, 128, 255, 26, 0, 255});
    expect_image(read(of({NAN, INFINITY, 0.0019f, 0.002f, 0, 0})), 2, 1, 3, {0, 255, 0, 1, 0, 0});
    EXPECT_CONTAINS(error_for(of({0, 0, 200, 180, 90, 100})), "above 1");
}

TEST(FloatColors, LinearLightIsEncoded) {
    codec::Raster raster;
    raster.width = 2, raster.height = 1, raster.channels = 3;
    raster.samples = std::vector<float>{0, 0.0002f, 0.2140f, 0.5f, 0.9999f, 1};
    const codec::Raster bytes = codec::to_bytes(raster, codec::FloatColors::linear, "a.exr");
    EXPECT_EQ(std::get<Bytes>(bytes.samples), (Bytes{0, 1, 127, 188, 255, 255}));
}

TEST(ReadTiff, RefusesTruncatedFiles) {
    for (int compression : {1, 5}) {
        const TiffKind kind{.samples = 3, .photometric = 2, .compression = compression};
        const Bytes whole = make_tiff(40, 30, gradient(40, 30, 3), kind);
        for (std::size_t length = 4; length + 1 < whole.size(); length += 13)
            EXPECT_FALSE(error_for(Bytes(whole.begin(), whole.begin() + length)).empty()) << length;
    }
}

TEST(ReadTiff, RefusesHugeHeadersBeforeAllocating) {
    for (int compression : {1, 5}) {
        const Bytes good = make_tiff(40, 30, gradient(40, 30, 1), {.compression = compression});
        for (const std::uint16_t side : {std::uint16_t{20000}, std::uint16_t{0xfff0}}) {
            Bytes file = good;
            // IFD entries of width (256) and height (257): tag, type SHORT, count 1, value
            for (std::uint8_t tag : {0, 1}) {
                const Bytes entry = {tag, 1, 3, 0, 1, 0, 0, 0};
                const auto found = std::search(file.begin(), file.end(), entry.begin(), entry.end());
                ASSERT_NE(found, file.end());
                found[8] = static_cast<std::uint8_t>(side), found[9] = static_cast<std::uint8_t>(side >> 8);
            }
            EXPECT_FALSE(error_for(file).empty());
        }
    }
}

TEST(ReadTiff, PrintsNothing) {
    testing::internal::CaptureStderr();
    Bytes file = make_tiff(40, 30, gradient(40, 30, 1), {.compression = 5});
    for (std::size_t i = 8; i < file.size(); i += 3) {
        Bytes damaged = file;
        damaged[i] ^= 0xff;
        try {
            read(damaged);
        } catch (const Error&) {
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ReadImage, RecognisesByContentNotName) {
    const Folder folder;
    EXPECT_EQ(read_image(folder.write("picture.jpg", make_png(3, 2, kGrey, {}))).pixels, kGrey);
}

TEST(ReadImage, RefusesWhatIsNoImage) {
    EXPECT_CONTAINS(error_for(to_bytes("hello, I am a text\n")), "text");
    EXPECT_CONTAINS(error_for({}), "empty");
    EXPECT_CONTAINS(error_for({0, 1, 2, 3, 4, 5, 6, 7, 8}), "not recognised");
    EXPECT_CONTAINS(error_for(make_pfm(1, 1, {1.f})), "PFM");
    EXPECT_CONTAINS(error_for({0xff, 0xd8, 0xff}), "JPEG");
    EXPECT_CONTAINS(error_for(to_bytes("\x89PNG\r\n\x1a\n")), "PNG");
    EXPECT_CONTAINS(error_for(to_bytes(std::string_view("II*\0", 4))), "TIFF");
    EXPECT_CONTAINS(error_for(to_bytes(std::string_view("RIFF\0\0\0\0WEBP", 12))), "WebP");
}

TEST(ReadImage, RefusesMissingFilesAndFolders) {
    const Folder folder;
    EXPECT_CONTAINS(error_of([&] { read_image(folder.path() / "none.png"); }), "no such file");
    EXPECT_CONTAINS(error_of([&] { read_image(folder.path()); }), "folder");
    EXPECT_CONTAINS(error_of([&] { read_image("/dev/null"); }), "regular");
    const auto file = folder.write("file.png", make_png(3, 2, kGrey, {}));
    EXPECT_CONTAINS(error_of([&] { read_image(file / "below.png"); }), "below.png");
}

TEST(ReadImage, RefusesUnreadableFiles) {
    if (geteuid() == 0) GTEST_SKIP() << "root may read everything: the unreadable file is not tested";
    const Folder folder;
    const auto locked = folder.write("locked.png", make_png(3, 2, kGrey, {}));
    std::filesystem::permissions(locked, std::filesystem::perms::none);
    EXPECT_CONTAINS(error_of([&] { read_image(locked); }), "ermission");
}

}  // namespace
}  // namespace hexrelief::readers
