// Tests files that hold both views.
#include "pipeline/readers/photographs/stereo_reader.h"

#include <array>
#include <random>

#include "tests/pipeline/readers/photographs/sample_exif.h"

namespace hexrelief::readers {
namespace {

// 4x4 pixels, each with its own value.
const Bytes kSamples{0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150};

StereoPair read(const Bytes& bytes, const StereoFileConfig& config = {}) {
    const Folder folder;
    return read_stereo_file(folder.write("stereo", bytes), config).views;
}

std::string error_for(const Bytes& bytes, const StereoFileConfig& config = {}) {
    return error_of_file("bad.mpo", bytes, [&](const auto& path) { read_stereo_file(path, config); });
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
        const StereoPair pair = read_stereo_file(folder.write(name, make_pgm(4, 4, 255, kSamples)), {}).views;
        EXPECT_EQ(pair.left.pixels, (Bytes{20, 30, 60, 70, 100, 110, 140, 150})) << name;
        EXPECT_EQ(pair.right.pixels, (Bytes{0, 10, 40, 50, 80, 90, 120, 130})) << name;
    }
}

TEST(ReadStereoFile, NamesMayTellTheLayout) {
    const Folder folder;
    const Bytes file = make_pgm(4, 4, 255, kSamples);
    for (const char* const name :
         {"calf-left-right.pgm", "Card.SBS.pgm", "a side-by-side 960.pgm", "sbs.pgm"}) {
        const StereoPair pair = read_stereo_file(folder.write(name, file), {}).views;
        EXPECT_EQ(pair.left.pixels, (Bytes{0, 10, 40, 50, 80, 90, 120, 130})) << name;
    }
    EXPECT_EQ(read_stereo_file(folder.write("x_over-under.pgm", file), {}).views.right.at(0, 0)[0], 80);
    EXPECT_EQ(read_stereo_file(folder.write("x_half-sbs.pgm", file), {}).views.left.width, 4);
    const Bytes screen = make_pgm(16, 9, 255, Bytes(16 * 9, 7));
    EXPECT_EQ(read_stereo_file(folder.write("film-sbs.pgm", screen), {}).views.left.width, 16) << "squeezed";
    EXPECT_EQ(read_stereo_file(folder.write("film.pgm", screen), {.layout = StereoLayout::side_by_side})
                  .views.left.width,
              8);
    EXPECT_THROW(read_stereo_file(folder.write("absbs.pgm", file), {}), Error) << "no word of its own";
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

// Returns the JPEG file with a segment in front.
Bytes with_segment(const Bytes& jpeg, std::uint8_t marker, const Bytes& content) {
    Bytes head{0xff, 0xd8, 0xff, marker};
    put(head, static_cast<std::uint32_t>(content.size() + 2), 2);
    return head + content + Bytes(jpeg.begin() + 2, jpeg.end());
}

// Appends a directory of one tag, big endian.
void put_directory(Bytes& index, std::uint32_t tag, std::uint32_t type, std::uint32_t count,
                   std::uint32_t value, std::uint32_t next = 0) {
    put(index, 1, 2);
    put(index, tag, 2);
    put(index, type, 2);
    put(index, count, 4);
    put(index, value, 4);
    put(index, next, 4);
}

const Bytes kIndexHead = to_bytes(std::string_view("MPF\0MM\0*\0\0\0\x08", 12));

struct MpoKind {
    std::uint32_t entries = 2;                      // that are listed
    std::uint32_t kind = 0x020002;                  // of the pictures: views of a pair
    std::array<std::uint32_t, 2> numbers = {0, 0};  // of the pictures' views; 0 = not told
};

// Returns two JPEG files with the index in the first one's APP2, big endian.
Bytes make_mpo(const Bytes& first, Bytes second, const MpoKind& kind = {}) {
    if (kind.numbers[1] > 0) {
        Bytes index = kIndexHead;
        put_directory(index, 0xb101, 4, 1, kind.numbers[1]);
        second = with_segment(second, 0xe2, index);
    }
    constexpr std::uint32_t directory = 18, list = 32;
    const bool is_told = kind.numbers[0] > 0;
    Bytes index = kIndexHead;
    put_directory(index, 0xb002, 7, 16 * kind.entries, 8 + directory, is_told ? 8 + directory + list : 0);
    const std::uint32_t before = 2 + 4 + 4;  // SOI, marker and length, "MPF"
    const auto first_bytes = static_cast<std::uint32_t>(first.size() + 4 + kIndexHead.size() + directory +
                                                        list + (is_told ? directory : 0));
    for (const auto& [size, offset] : {std::pair<std::uint32_t, std::uint32_t>{first_bytes, 0},
                                       {static_cast<std::uint32_t>(second.size()), first_bytes - before}}) {
        put(index, kind.kind, 4);
        put(index, size, 4);
        put(index, offset, 4);
        put(index, 0, 4);
    }
    if (is_told) put_directory(index, 0xb101, 4, 1, kind.numbers[0]);
    return with_segment(first, 0xe2, index) + second;
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

TEST(ReadStereoFile, MpoByTheNumbersOfItsViews) {
    const auto left_of = [](std::uint32_t first, std::uint32_t second, bool right_first = false) {
        const Bytes mpo = make_mpo(grey_jpeg(40), grey_jpeg(200), {.numbers = {first, second}});
        return read(mpo, {.right_first = right_first}).left.at(3, 3)[0];
    };
    EXPECT_NEAR(left_of(1, 2), 40, 1);
    EXPECT_NEAR(left_of(2, 1), 200, 1);
    EXPECT_NEAR(left_of(2, 1, true), 200, 1) << "the file has said it already";
    EXPECT_NEAR(left_of(0xffffffff, 1), 40, 1) << "a number that says nothing";
    EXPECT_NEAR(left_of(2, 0), 40, 1);
}

TEST(ReadStereoFile, PreviewsAreNoViews) {
    const Bytes previews = make_mpo(grey_jpeg(40), grey_jpeg(200), {.kind = 0x010001});
    EXPECT_CONTAINS(error_for(previews), "previews");
    const Folder folder;
    EXPECT_FALSE(describe_stereo_file(folder.write("a.jpg", previews)));
}

// separation, flags (1 and 2: squeezed, 4: left view first), layout (2: side by side, 3: one above the
// other), type (1: a pair)
Bytes make_jps(std::uint8_t flags, std::uint8_t layout, std::uint8_t type = 1) {
    Bytes halves;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 32; ++x) halves.push_back((layout == 3 ? y < 8 : x < 16) ? 40 : 200);
    return with_segment(make_jpeg(32, 16, halves, JpegKind::grey), 0xe3,
                        to_bytes("_JPSJPS_") + Bytes{0, 4, 0, flags, layout, type});
}

TEST(ReadStereoFile, JpsByItsDescriptor) {
    const StereoPair crossed = read(make_jps(0, 2)), parallel = read(make_jps(4, 2));
    EXPECT_EQ(crossed.left.width, 16);
    EXPECT_NEAR(crossed.left.at(3, 3)[0], 200, 2);
    EXPECT_NEAR(parallel.left.at(3, 3)[0], 40, 2);
    const StereoPair above = read(make_jps(4, 3)), squeezed = read(make_jps(4 + 2, 2));
    EXPECT_EQ(above.left.height, 8);
    EXPECT_NEAR(above.left.at(3, 3)[0], 40, 2);
    EXPECT_EQ(squeezed.left.width, 32);
    EXPECT_NEAR(squeezed.right.at(20, 3)[0], 200, 2);
    EXPECT_NEAR(read(make_jps(0, 2), {.layout = StereoLayout::side_by_side}).left.at(3, 3)[0], 200, 2)
        << "the order is the file's, though the layout is given";
    EXPECT_CONTAINS(error_for(make_jps(4, 1)), "--layout");
    EXPECT_CONTAINS(error_for(make_jps(4, 2, 0)), "--layout");
    Bytes cut = make_jps(4, 2);
    cut.resize(18);
    EXPECT_CONTAINS(error_for(cut), "bad.mpo");
}

TEST(ReadStereoFile, BothViewsAreTurnedAsTheFirstPictureSays) {
    const Folder folder;
    const Bytes turned = with_exif(grey_jpeg(40, 16), orientation_exif(6)) + grey_jpeg(200, 16);
    const auto path = folder.write("a.jpg", turned);
    const StereoViews read = read_stereo_file(path, {});
    EXPECT_EQ(read.views.left.height, 16);
    EXPECT_EQ(read.views.right.height, 16);
    EXPECT_CONTAINS(read.told, "turned by a quarter clockwise by EXIF");
    EXPECT_EQ(read_stereo_file(path, {}, {}, false).views.right.height, 8);
    // The halves are those of the picture as it is seen: what is stored above is then to the right.
    const Bytes halves = Bytes(128, 40) + Bytes(128, 200);
    const auto side =
        folder.write("b.jpg", with_exif(make_jpeg(16, 16, halves, JpegKind::grey), orientation_exif(6)));
    const StereoPair pair = read_stereo_file(side, {.layout = StereoLayout::side_by_side}).views;
    EXPECT_NEAR(pair.left.at(3, 3)[0], 200, 2);
    EXPECT_NEAR(pair.right.at(3, 3)[0], 40, 2);
}

TEST(DescribeStereoFile, TellsOfBothViewsAsTheyWouldBeRead) {
    const Folder folder;
    const auto described = [&](const std::string& name, const Bytes& bytes) {
        return describe_stereo_file(folder.write(name, bytes));
    };
    const auto mpo = described("a", make_mpo(grey_jpeg(40), grey_jpeg(200), {.numbers = {2, 1}}));
    ASSERT_TRUE(mpo);
    EXPECT_EQ(mpo->width, 8);
    EXPECT_CONTAINS(mpo->told, "right view first by their numbers");
    const auto jps = described("b", make_jps(4, 2));
    ASSERT_TRUE(jps);
    EXPECT_EQ(jps->width, 16);
    EXPECT_CONTAINS(jps->told, "side by side, left view first, by its JPS descriptor");
    const auto named = described("c.jps", make_pgm(5, 4, 255, Bytes(20, 7)));
    ASSERT_TRUE(named);
    EXPECT_EQ(named->width, 2);
    EXPECT_CONTAINS(named->told, "cross-eyed");
    EXPECT_FALSE(described("d", grey_jpeg(40)));
    EXPECT_FALSE(described("e", grey_jpeg(40) + grey_jpeg(200, 16))) << "no pair";
    EXPECT_FALSE(described("f", make_pgm(4, 4, 255, Bytes(16, 7))));
    EXPECT_FALSE(described("g", to_bytes("text")));
}

TEST(ListPictures, NamesEachOfAJpegFile) {
    const Folder folder;
    const auto listed = [&](const Bytes& bytes) { return list_pictures(folder.write("a.jpg", bytes)); };
    using Lines = std::vector<std::string>;
    const Bytes first = grey_jpeg(40), second = grey_jpeg(200, 16);
    EXPECT_EQ(listed(first), Lines{});
    EXPECT_EQ(listed(make_mpo(first, second)),
              (Lines{"8 x 8 px, the first picture", "16 x 8 px, view of a pair"}));
    EXPECT_EQ(listed(make_mpo(first, second, {.kind = 0x010001})),
              (Lines{"8 x 8 px, the first picture", "16 x 8 px, preview"}));
    EXPECT_EQ(listed(first + Bytes(36, 0) + second + first),
              (Lines{"8 x 8 px, the first picture", "16 x 8 px, behind the one before",
                     "8 x 8 px, behind the one before"}));
    EXPECT_EQ(listed(make_mpo(first, Bytes(20, 1))),
              (Lines{"8 x 8 px, the first picture", "view of a pair, damaged"}));
    EXPECT_EQ(listed(make_pgm(4, 4, 255, kSamples)), Lines{});
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
    EXPECT_CONTAINS(error_for(make_mpo(grey_jpeg(40), grey_jpeg(200), {.entries = 1})), "no second picture");
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
        test::refusal_of([&] { read_stereo_file(folder.write("damaged", bytes), {}); });
    }
}

}  // namespace
}  // namespace hexrelief::readers
