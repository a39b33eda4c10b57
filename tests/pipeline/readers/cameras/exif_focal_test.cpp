// Tests EXIF data with a few tags, written by hand by the standard.
#include "pipeline/readers/cameras/exif_focal.h"

#include <cmath>
#include <random>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

constexpr std::uint16_t kShort = 3, kLong = 4, kRational = 5;

struct Tag {
    std::uint16_t id, type;
    std::uint32_t value, denominator = 1;
};

const Tag kFilm{0xa405, kShort, 28}, kLens{0x920a, kRational, 42, 10},
    kResolution{0xa20e, kRational, 16000, 3}, kUnit{0xa210, kShort, 2}, kTaken{0xa002, kLong, 4000};

void put(Bytes& bytes, std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

// Returns an APP1 segment with one entry in IFD 0, which points to the EXIF directory with
// `tags`; rationals follow it.
Bytes app1(const std::vector<Tag>& tags) {
    Bytes tiff;
    put(tiff, 0x4949, 2);
    put(tiff, 42, 2);
    put(tiff, 8, 4);
    put(tiff, 1, 2);
    put(tiff, 0x8769, 2);
    put(tiff, kLong, 2);
    put(tiff, 1, 4);
    put(tiff, 26, 4);
    put(tiff, 0, 4);
    put(tiff, static_cast<std::uint32_t>(tags.size()), 2);
    Bytes rationals;
    const std::uint32_t behind = 26 + 2 + 12 * static_cast<std::uint32_t>(tags.size()) + 4;
    for (const Tag& tag : tags) {
        put(tiff, tag.id, 2);
        put(tiff, tag.type, 2);
        put(tiff, 1, 4);
        if (tag.type == kRational) {
            put(tiff, behind + static_cast<std::uint32_t>(rationals.size()), 4);
            put(rationals, tag.value, 4);
            put(rationals, tag.denominator, 4);
        } else {
            put(tiff, tag.value, 4);
        }
    }
    put(tiff, 0, 4);
    const Bytes body = to_bytes(std::string_view("Exif\0\0", 6)) + tiff + rationals;
    const std::size_t length = body.size() + 2;
    return Bytes{0xff, 0xe1, static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length)} +
           body;
}

Bytes photograph(const std::vector<Tag>& tags) {
    const Bytes jpeg = make_jpeg(4, 3, Bytes(12, 100), JpegKind::grey);
    return Bytes(jpeg.begin(), jpeg.begin() + 2) + app1(tags) + Bytes(jpeg.begin() + 2, jpeg.end());
}

std::optional<ExifFocal> read(const Bytes& bytes, int width = 2000, int height = 1500) {
    const Folder folder;
    return read_exif_focal(folder.write("photo.jpg", bytes), width, height);
}

TEST(ReadExifFocal, OfFilmByTheDiagonal) {
    const auto focal = read(photograph({kFilm}));
    ASSERT_TRUE(focal);
    EXPECT_NEAR(focal->focal_px, 28 * 2500 / std::hypot(36, 24), 1e-6);
    EXPECT_EQ(focal->believed, "28 mm on 35 mm film");
}

TEST(ReadExifFocal, OfTheSensorsResolution) {
    // 16000 / 3 px per inch: 4000 px are 19.05 mm.
    const auto focal = read(photograph({kTaken, kLens, kResolution, kUnit}));
    ASSERT_TRUE(focal);
    EXPECT_NEAR(focal->focal_px, 4.2 / 19.05 * 2000, 1e-6);
    EXPECT_EQ(focal->believed, "4.2 mm on a sensor of 19 mm");
    EXPECT_EQ(read(photograph({kFilm, kLens, kResolution}))->believed, "28 mm on 35 mm film");
}

TEST(ReadExifFocal, NothingWhereItIsNotTold) {
    EXPECT_FALSE(read(photograph({})));
    EXPECT_FALSE(read(photograph({kLens})));
    EXPECT_FALSE(read(photograph({{kFilm.id, kShort, 0}})));
    EXPECT_FALSE(read(photograph({{kFilm.id, kShort, 65535}})));
    EXPECT_FALSE(read(photograph({{kLens.id, kRational, 42, 0}, kResolution})));
    EXPECT_FALSE(read(make_jpeg(4, 3, Bytes(12, 100), JpegKind::grey)));
    EXPECT_FALSE(read(make_pgm(4, 3, 255, Bytes(12, 100))));
    EXPECT_FALSE(read({}));
}

TEST(ReadExifFocal, DamagedDataAreNoneOrALens) {
    const Bytes good = photograph({kTaken, kLens, kResolution, kUnit, kFilm});
    std::mt19937 random(20240229);
    const Folder folder;
    for (int i = 0; i < 300; ++i) {
        Bytes bytes = good;
        if (i % 4 == 3)
            bytes.resize(random() % bytes.size());
        else
            bytes[random() % 140] = static_cast<std::uint8_t>(random());
        const auto focal = read_exif_focal(folder.write("photo.jpg", bytes), 2000, 1500);
        if (focal) {
            EXPECT_TRUE(focal->focal_px > 0 && focal->focal_px < 1.3e6) << i;
        }
    }
}

}  // namespace
}  // namespace hexrelief::readers
