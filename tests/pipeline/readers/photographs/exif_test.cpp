// Tests the orientation in photographs, and that pictures are turned by it.
#include "pipeline/readers/photographs/exif.h"

#include <random>

#include "tests/pipeline/readers/photographs/sample_exif.h"

namespace hexrelief::readers {
namespace {

int orientation_of(const Bytes& bytes) {
    const Folder folder;
    return read_orientation(folder.write("photo", bytes));
}

const Bytes kJpeg = make_jpeg(4, 3, Bytes(12, 100), JpegKind::grey);

TEST(ReadOrientation, OfJpegInEitherByteOrder) {
    for (int orientation = 1; orientation <= 8; ++orientation)
        for (const bool is_big : {false, true})
            EXPECT_EQ(orientation_of(with_exif(kJpeg, orientation_exif(orientation, is_big))), orientation);
    EXPECT_EQ(orientation_of(kJpeg), kUpright);
    EXPECT_EQ(orientation_of(with_exif(kJpeg, orientation_exif(0))), kUpright);
    EXPECT_EQ(orientation_of(with_exif(kJpeg, orientation_exif(9))), kUpright);
}

TEST(ReadOrientation, OfPngAndWebpChunks) {
    const Bytes exif = orientation_exif(6);
    const Bytes png = make_png(2, 1, {1, 2}, {});
    const Bytes chunk =
        Bytes{0, 0, 0, static_cast<std::uint8_t>(exif.size())} + to_bytes("eXIf") + exif + Bytes(4, 0);
    constexpr std::ptrdiff_t behind_header = 33;
    EXPECT_EQ(orientation_of(Bytes(png.begin(), png.begin() + behind_header) + chunk +
                             Bytes(png.begin() + behind_header, png.end())),
              6);
    const Bytes webp = make_webp(2, 2, Bytes(16, 200), true);
    EXPECT_EQ(orientation_of(webp + to_bytes("EXIF") +
                             Bytes{static_cast<std::uint8_t>(exif.size()), 0, 0, 0} + exif),
              6);
}

TEST(ReadOrientation, OfTiffsTag) {
    for (const bool is_big : {false, true})
        EXPECT_EQ(orientation_of(make_tiff(2, 1, {1, 2}, {.big_endian = is_big, .orientation = 8})), 8);
}

TEST(ReadOrientation, OtherFilesAreUpright) {
    EXPECT_EQ(orientation_of(make_pgm(2, 1, 255, {1, 2})), kUpright);
    EXPECT_EQ(orientation_of({}), kUpright);
    EXPECT_EQ(orientation_of(to_bytes("text")), kUpright);
    const Folder folder;
    EXPECT_CONTAINS(error_of([&] { read_orientation(folder.path() / "none.jpg"); }), "none.jpg");
}

TEST(ReadOrientation, DamagedDataEndAndGiveAnOrientation) {
    const Folder folder;
    std::mt19937 random(20240229);
    for (const Bytes& good :
         {with_exif(kJpeg, orientation_exif(6)), make_tiff(2, 1, {1, 2}, {.orientation = 6}),
          make_webp(2, 2, Bytes(16, 200), true) + to_bytes("EXIF") + Bytes{26, 0, 0, 0} +
              orientation_exif(6)})
        for (int i = 0; i < 300; ++i) {
            Bytes bytes = good;
            bytes[random() % std::min<std::size_t>(bytes.size(), 70)] = static_cast<std::uint8_t>(random());
            if (i % 4 == 3) bytes.resize(random() % bytes.size());
            const int orientation = orientation_of(bytes);
            EXPECT_TRUE(orientation >= 1 && orientation <= 8) << orientation;
        }
}

// The letter of a pixel is its place in the upright picture: ab / cd / ef.
TEST(Upright, AllEightOrientations) {
    const Bytes seen = {'a', 'b', 'c', 'd', 'e', 'f'};  // 2 x 3
    const struct {
        int orientation, width;
        const char* stored;
    } cases[] = {{1, 2, "abcdef"}, {2, 2, "badcfe"}, {3, 2, "fedcba"}, {4, 2, "efcdab"},
                 {5, 3, "acebdf"}, {6, 3, "bdface"}, {7, 3, "fdbeca"}, {8, 3, "ecafdb"}};
    for (const auto& one : cases) {
        const Bytes stored = to_bytes(one.stored);
        const Image image = upright(Image{one.width, 6 / one.width, 1, stored, stored}, one.orientation);
        EXPECT_EQ(image.width, 2) << one.orientation;
        EXPECT_EQ(image.height, 3) << one.orientation;
        EXPECT_EQ(image.pixels, seen) << one.orientation;
        EXPECT_EQ(image.alpha, seen) << one.orientation;
    }
    const Image colors = upright(Image{2, 1, 3, {1, 2, 3, 4, 5, 6}, {}}, 3);
    EXPECT_EQ(colors.pixels, (Bytes{4, 5, 6, 1, 2, 3}));
    EXPECT_TRUE(colors.alpha.empty());
}

}  // namespace
}  // namespace hexrelief::readers
