// Tests HEIC photographs and the depths beside them.
#include <algorithm>
#include <random>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/heic_boxes.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/photographs/stereo_reader.h"
#include "tests/pipeline/readers/depth/sample_boxes.h"
#include "tests/pipeline/readers/depth/sample_maps.h"
#include "tests/pipeline/readers/sample_profiles.h"

namespace hexrelief::readers {
namespace {

constexpr int kWidth = 64, kHeight = 64;

// Returns a photograph of one colour with depths of 0 to 252 in columns.
Bytes sample(const std::string& xmp) {
    Bytes pixels;
    for (int i = 0; i < kWidth * kHeight; ++i)
        pixels = std::move(pixels) + Bytes{200, 100, 50, static_cast<std::uint8_t>(i % kWidth * 4)};
    return make_heic(kWidth, kHeight, pixels, xmp);
}

std::string apple_xmp(const std::string& type) {
    return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:Description apdi:AuxiliaryImageType=\"" + type +
           "\"><apdi:FloatMinValue>0.5</apdi:FloatMinValue><apdi:FloatMaxValue>3.05</apdi:FloatMaxValue>"
           "</rdf:Description></x:xmpmeta>";
}

class Heic : public testing::Test {
  protected:
    void SetUp() override {
        if (sample("").empty()) GTEST_SKIP() << "libheif has no HEVC encoder here: HEIC files are not tested";
    }
};

TEST_F(Heic, ThePictureAndItsDepthsAreRead) {
    const Folder folder;
    const auto path = folder.write("a.heic", sample(apple_xmp("disparity")));
    const Image picture = read_image(path);
    ASSERT_EQ(picture.width, kWidth);
    ASSERT_EQ(picture.channels, 3);
    EXPECT_NEAR(picture.at(30, 30)[0], 200, 3);
    EXPECT_NEAR(picture.at(30, 30)[2], 50, 3);
    const DepthFile file = read_depth_map(path, {});
    ASSERT_EQ(file.map.values.size(), static_cast<std::size_t>(kWidth) * kHeight);
    EXPECT_CONTAINS(file.believed, "range by its XMP, inverse depth, 1/(m)");
    EXPECT_TRUE(file.map.metric);
    for (const int x : {0, 20, 63}) EXPECT_NEAR(file.map.values[x], 1 / (0.5 + 0.01 * 4 * x), 0.02) << x;
    EXPECT_EQ(describe_raster(path)->format, "heic");
    EXPECT_EQ(describe_raster(path)->width, kWidth);
    EXPECT_CONTAINS(error_of([&] { read_disparity_map(path, {}); }), "--depth");
}

TEST_F(Heic, DisplayP3BecomesSrgb) {
    const Folder folder;
    Bytes pixels;
    for (int i = 0; i < kWidth * kHeight; ++i) pixels = std::move(pixels) + Bytes{200, 100, 50, 90};
    const Image picture =
        read_image(folder.write("p3.heic", make_heic(kWidth, kHeight, pixels, "", display_p3_profile())));
    EXPECT_NEAR(picture.at(30, 30)[0], 214, 3);
    EXPECT_NEAR(picture.at(30, 30)[1], 93, 3);
    EXPECT_NEAR(picture.at(30, 30)[2], 31, 4);
}

TEST_F(Heic, BothPicturesOfASpatialPhotographAreRead) {
    const Folder folder;
    const Bytes file = make_heic_pair({200, 100, 50}, {50, 100, 200});
    const StereoPair pair = read_stereo_file(folder.write("a.heic", file), {}).views;
    ASSERT_EQ(pair.left.width, kWidth);
    EXPECT_NEAR(pair.left.at(30, 30)[0], 50, 3);  // the group names the second picture first
    EXPECT_NEAR(pair.right.at(30, 30)[0], 200, 3);
    const StereoPair swapped = read_stereo_file(folder.write("b.heic", file), {.right_first = true}).views;
    EXPECT_NEAR(swapped.left.at(30, 30)[0], 200, 3);
    const auto one = folder.write("c.heic", sample(""));
    EXPECT_CONTAINS(error_of([&] { read_stereo_file(one, {}); }), "with one picture");
    std::mt19937 random(7);
    for (int i = 0; i < 100; ++i) {
        Bytes damaged = file;
        damaged[random() % 600] = static_cast<std::uint8_t>(random());
        test::refusal_of([&] { read_stereo_file(folder.write("d.heic", damaged), {}); });
    }
}

TEST_F(Heic, WhatTheDepthsAreIsSaidByTheFile) {
    const Folder folder;
    const DepthFile metres = read_depth_map(folder.write("m.heic", sample(apple_xmp("depth"))), {});
    EXPECT_CONTAINS(metres.believed, "range by its XMP, m");
    EXPECT_NEAR(metres.map.values[20], 0.5 + 0.01 * 80, 0.02);
    const DepthFile ranged = read_depth_map(folder.write("i.heic", with_representation(sample(""))), {});
    EXPECT_CONTAINS(ranged.believed, "range by its representation information, inverse depth");
    EXPECT_NEAR(ranged.map.values[0], 4, 0.01);
    EXPECT_NEAR(ranged.map.values[20], 1 / (0.25 + 1.75 * 80 / 255), 0.01);
    const DepthFile relative = read_depth_map(folder.write("r.heic", sample("")), {});
    EXPECT_CONTAINS(relative.believed, "no range said");
    EXPECT_FALSE(relative.map.metric);
    EXPECT_GT(relative.map.values[1], relative.map.values[63]);
}

// libheif can only limit the sides, and a file of a thousand bytes may be decoded to any size.
TEST_F(Heic, NoSideIsLongerThanThatOfTheLargestSquare) {
    const Folder folder;
    const auto path = folder.write("long.heic", make_heic(256, 16, Bytes(256 * 16 * 4, 90), ""));
    EXPECT_EQ(read_image(path, {.max_pixels = 256 * 256}).width, 256);
    EXPECT_CONTAINS(error_of([&] { read_image(path, {.max_pixels = 256 * 256 - 1}); }), "255");
}

TEST_F(Heic, DamagedFilesReadOrAreRefused) {
    const Folder folder;
    const Bytes good = sample(apple_xmp("disparity"));
    std::mt19937 random(20240229);
    for (int i = 0; i < 60; ++i) {
        Bytes bytes = good;
        bytes[12 + random() % (i % 2 ? bytes.size() - 12 : 600)] = static_cast<std::uint8_t>(random());
        if (i % 4 == 3) bytes.resize(12 + random() % (bytes.size() - 12));
        const auto path = folder.write("damaged", bytes);
        test::refusal_of([&] { read_image(path); });
        test::refusal_of([&] { read_depth_map(path, {}); });
    }
}

struct Reference {
    const char* type;
    int from;
    std::vector<int> to;
    int longer = 0;
};

// Returns the message of check_derivations() for a file with these item references; empty if
// it accepts the file.
std::string refusal(const std::vector<Reference>& references, int id_bytes = 2) {
    Bytes iref = big_endian(id_bytes == 2 ? 0 : 1, 1) + Bytes(3, 0);
    for (const Reference& reference : references) {
        Bytes content = big_endian(reference.from, id_bytes) + big_endian(reference.to.size(), 2);
        for (const int to : reference.to) content = std::move(content) + big_endian(to, id_bytes);
        iref = std::move(iref) + box(reference.type, content, reference.longer);
    }
    const codec::SourceFile file{
        "a.heic", box("ftyp", to_bytes("heic")) + box("meta", Bytes(4, 0) + box("iref", iref))};
    return test::refusal_of([&] { codec::check_derivations(file); });
}

std::vector<Reference> chain(int length) {
    std::vector<Reference> references;
    for (int i = 0; i < length; ++i) references.push_back({"dimg", i, {i + 1}});
    return references;
}

TEST(HeicDerivations, PicturesOfPicturesHaveAnEnd) {
    EXPECT_EQ(refusal({}), "");
    EXPECT_EQ(
        refusal({{"dimg", 9, {1, 2, 3, 4}}, {"auxl", 5, {9}}, {"dimg", 5, {6, 7}}, {"dimg", 8, {9, 5}}}), "");
    for (const int id_bytes : {2, 4}) {
        EXPECT_CONTAINS(refusal({{"dimg", 4, {4}}}, id_bytes), "in a circle");
        EXPECT_CONTAINS(refusal({{"dimg", 1, {2, 3}}, {"dimg", 3, {4, 1}}}, id_bytes), "in a circle");
        EXPECT_CONTAINS(refusal({{"auxl", 1, {2}}, {"auxl", 2, {1}}}, id_bytes), "in a circle");
    }
    EXPECT_EQ(refusal({{"thmb", 1, {1}}}), "");  // never decoded
    // libheif finds the next reference after the items, not at the stated length.
    EXPECT_CONTAINS(refusal({{"thmb", 1, {1}, 99}, {"dimg", 4, {4}}}), "length of a reference");
    EXPECT_CONTAINS(refusal({{"thmb", 1, {}, -2}, {"dimg", 4, {4}}}), "length of a reference");
    EXPECT_EQ(refusal(chain(8)), "");
    EXPECT_CONTAINS(refusal(chain(9)), "8 deep");
    std::vector<Reference> backwards = chain(9);
    std::reverse(backwards.begin(), backwards.end());
    EXPECT_CONTAINS(refusal(backwards), "8 deep");
}

TEST(HeicDerivations, PicturesAreCounted) {
    const std::vector<int> many(1000, 2), few(10, 3), sixteen(16, 3);
    EXPECT_EQ(refusal({{"dimg", 1, many}, {"dimg", 2, few}}), "");
    EXPECT_CONTAINS(refusal({{"dimg", 1, many}, {"dimg", 2, sixteen}}), "16384");
}

}  // namespace
}  // namespace hexrelief::readers
