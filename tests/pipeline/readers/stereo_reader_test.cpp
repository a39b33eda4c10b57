// Tests files that hold both views.
#include "pipeline/readers/stereo_reader.h"

#include <random>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

// 4x4 pixels, each with its own value.
const Bytes kSamples{0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150};

StereoPair read(const Bytes& bytes, const StereoFileConfig& config = {}) {
    const Folder folder;
    return read_stereo_file(folder.write("stereo", bytes), config);
}

std::string error_for(const Bytes& bytes, const StereoFileConfig& config = {}) {
    const Folder folder;
    const auto path = folder.write("bad.mpo", bytes);
    const std::string message = error_of([&] { read_stereo_file(path, config); });
    EXPECT_CONTAINS(message, "bad.mpo");
    return message;
}

TEST(ReadStereoFile, HalvesSideBySideAndTopBottom) {
    const Bytes file = make_pgm(4, 4, 255, kSamples);
    const StereoPair side = read(file, {.layout = StereoLayout::side_by_side});
    EXPECT_EQ(side.left.pixels, (Bytes{0, 10, 40, 50, 80, 90, 120, 130}));
    EXPECT_EQ(side.right.pixels, (Bytes{20, 30, 60, 70, 100, 110, 140, 150}));
    const StereoPair top = read(file, {.layout = StereoLayout::top_bottom, .right_first = true});
    EXPECT_EQ(top.right.pixels, (Bytes{0, 10, 20, 30, 40, 50, 60, 70}));
    EXPECT_EQ(top.left.height, 2);
}

TEST(ReadStereoFile, HalfFormsAreStretchedBetweenPixelCentres) {
    const Bytes file = make_pgm(4, 4, 255, kSamples);
    const StereoPair side = read(file, {.layout = StereoLayout::half_side_by_side});
    EXPECT_EQ(side.left.width, 4);
    EXPECT_EQ(side.left.height, 4);
    EXPECT_EQ(Bytes(side.left.pixels.begin(), side.left.pixels.begin() + 4), (Bytes{0, 3, 8, 10}));
    const StereoPair top = read(file, {.layout = StereoLayout::half_top_bottom});
    EXPECT_EQ(top.left.height, 4);
    EXPECT_EQ(top.left.at(0, 1)[0], 10);
    EXPECT_EQ(top.left.at(0, 2)[0], 30);
}

TEST(ReadStereoFile, ViewsKeepTheirPixelsAlpha) {
    const Bytes png = make_png(4, 2, {9, 0, 9, 1, 9, 2, 9, 3, 9, 4, 9, 5, 9, 6, 9, 7}, {.colour_type = 4});
    const auto views = [&](StereoLayout layout) { return read(png, {.layout = layout}); };
    EXPECT_EQ(views(StereoLayout::side_by_side).left.alpha, (Bytes{0, 1, 4, 5}));
    EXPECT_EQ(views(StereoLayout::side_by_side).right.alpha, (Bytes{2, 3, 6, 7}));
    EXPECT_EQ(views(StereoLayout::half_top_bottom).right.alpha, (Bytes{4, 5, 6, 7, 4, 5, 6, 7}));
}

TEST(ReadStereoFile, TheMiddleOfAnOddSideBelongsToNoHalf) {
    const Bytes odd = make_pgm(3, 3, 255, {0, 1, 2, 10, 11, 12, 20, 21, 22});
    const StereoPair side = read(odd, {.layout = StereoLayout::side_by_side});
    EXPECT_EQ(side.left.pixels, (Bytes{0, 10, 20}));
    EXPECT_EQ(side.right.pixels, (Bytes{2, 12, 22}));
    const StereoPair top = read(odd, {.layout = StereoLayout::top_bottom});
    EXPECT_EQ(top.left.pixels, (Bytes{0, 1, 2}));
    EXPECT_EQ(top.right.pixels, (Bytes{20, 21, 22}));
}

TEST(ReadStereoFile, JpsAndPnsHaveTheRightViewFirst) {
    const Folder folder;
    for (const char* const name : {"a.jps", "b.PNS"}) {
        const StereoPair pair = read_stereo_file(folder.write(name, make_pgm(4, 4, 255, kSamples)), {});
        EXPECT_EQ(pair.left.pixels, (Bytes{20, 30, 60, 70, 100, 110, 140, 150})) << name;
        EXPECT_EQ(pair.right.pixels, (Bytes{0, 10, 40, 50, 80, 90, 120, 130})) << name;
    }
}

TEST(ReadStereoFile, RefusesWhatCannotBeHalved) {
    const Bytes thin = make_pgm(1, 1, 255, Bytes(1, 1));
    EXPECT_CONTAINS(error_for(thin, {.layout = StereoLayout::side_by_side}), "no two halves");
    EXPECT_CONTAINS(error_for(thin, {.layout = StereoLayout::half_top_bottom}), "no two halves");
    EXPECT_CONTAINS(error_for(thin), "--layout");
    EXPECT_CONTAINS(error_for(thin, {.layout = StereoLayout::mpo}), "MPO");
    EXPECT_CONTAINS(error_for({}, {.layout = StereoLayout::side_by_side}), "empty");
}

void put(Bytes& bytes, std::uint32_t value, int size) {
    for (int i = size - 1; i >= 0; --i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

// Returns two JPEG files with the index in the first one's APP2, big endian. entries: the
// number of pictures listed.
Bytes make_mpo(const Bytes& first, const Bytes& second, std::uint32_t entries = 2) {
    Bytes index;
    put(index, 0x4d4d002a, 4);
    put(index, 8, 4);
    put(index, 1, 2);
    put(index, 0xb002, 2);
    put(index, 7, 2);
    put(index, 16 * entries, 4);
    put(index, 26, 4);
    put(index, 0, 4);
    const std::uint32_t before = 2 + 4 + 4, length = 2 + 4 + 26 + 32;  // SOI, marker and length, "MPF"
    const auto first_bytes = static_cast<std::uint32_t>(first.size()) + 2 + length;
    for (const auto& [size, offset] : {std::pair<std::uint32_t, std::uint32_t>{first_bytes, 0},
                                       {static_cast<std::uint32_t>(second.size()), first_bytes - before}}) {
        put(index, 0x020002, 4);
        put(index, size, 4);
        put(index, offset, 4);
        put(index, 0, 4);
    }
    Bytes app2{0xff, 0xe2};
    put(app2, length, 2);
    app2 = app2 + to_bytes(std::string_view("MPF\0", 4)) + index;
    return Bytes(first.begin(), first.begin() + 2) + app2 + Bytes(first.begin() + 2, first.end()) + second;
}

Bytes grey_jpeg(std::uint8_t value, int width = 8) {
    return make_jpeg(width, 8, Bytes(static_cast<std::size_t>(width) * 8, value), JpegKind::grey);
}

TEST(ReadStereoFile, MpoByItsIndex) {
    const StereoPair pair = read(make_mpo(grey_jpeg(40), grey_jpeg(200)));
    EXPECT_NEAR(pair.left.at(3, 3)[0], 40, 1);
    EXPECT_NEAR(pair.right.at(3, 3)[0], 200, 1);
    EXPECT_NEAR(read(make_mpo(grey_jpeg(40), grey_jpeg(200)), {.right_first = true}).left.at(3, 3)[0], 200,
                1);
}

TEST(ReadStereoFile, ASecondJpegBehindTheFirst) {
    const Bytes first = grey_jpeg(40), second = grey_jpeg(200);
    const StereoPair pair = read(first + second);
    EXPECT_NEAR(pair.left.at(3, 3)[0], 40, 1);
    EXPECT_NEAR(pair.right.at(3, 3)[0], 200, 1);
    EXPECT_NEAR(read(first + Bytes(36, 0) + second).right.at(3, 3)[0], 200, 1);  // as in LIF
    EXPECT_CONTAINS(error_for(first + Bytes(64, 0)), "--layout");
    EXPECT_CONTAINS(error_for(first + grey_jpeg(200, 16)), "8x8 and 16x8");
    EXPECT_CONTAINS(error_for(Bytes(first.begin(), first.end() - 2) + second), "--layout");
}

TEST(ReadStereoFile, MalformedMpoIsRefused) {
    EXPECT_CONTAINS(error_for(make_mpo(grey_jpeg(40), grey_jpeg(200, 16))), "8x8 and 16x8");
    EXPECT_CONTAINS(error_for(make_mpo(grey_jpeg(40), grey_jpeg(200), 1)), "no second picture");
    Bytes cut = make_mpo(grey_jpeg(40), grey_jpeg(200));
    cut.resize(cut.size() - 5);
    EXPECT_CONTAINS(error_for(cut), "outside of the file");
    EXPECT_CONTAINS(error_for(grey_jpeg(40)), "--layout");
    Bytes order = make_mpo(grey_jpeg(40), grey_jpeg(200));
    order[10] = 'x';
    EXPECT_CONTAINS(error_for(order), "byte order");

    const Bytes good = make_mpo(grey_jpeg(40), grey_jpeg(200));
    std::mt19937 random(20240229);
    const Folder folder;
    for (int i = 0; i < 200; ++i) {
        Bytes bytes = good;
        bytes[random() % 80] = static_cast<std::uint8_t>(random());
        if (i % 4 == 3) bytes.resize(random() % bytes.size());
        try {
            read_stereo_file(folder.write("damaged", bytes), {});
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
        }
    }
}

}  // namespace
}  // namespace hexrelief::readers
