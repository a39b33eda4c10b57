#include "pipeline/readers/depth/mask_reader.h"

#include "tests/pipeline/readers/depth/sample_maps.h"

namespace hexrelief::readers {
namespace {

std::string kept_text(const PixelMask& mask) {
    std::string text;
    for (const std::uint8_t kept : mask.kept) text += kept ? '1' : '0';
    return text;
}

std::string kept_by(const Bytes& file, const MaskConfig& config = {}) {
    const Folder folder;
    return kept_text(read_mask(folder.write("mask", file), config));
}

std::string kept_above(const Bytes& file, double threshold) {
    const Folder folder;
    return kept_text(read_confidence(folder.write("confidence", file), {.threshold = threshold}));
}

TEST(Mask, WhatIsNotZeroInAnyChannelIsKept) {
    const Bytes grey = make_png(4, 1, {0, 1, 255, 0}, {});
    EXPECT_EQ(kept_by(grey), "0110");
    EXPECT_EQ(kept_by(grey, {.inverted = true}), "1001");
    EXPECT_EQ(kept_by(make_png(2, 1, {0, 0, 0, 0, 0, 9}, {.colour_type = 2})), "01");
    EXPECT_EQ(kept_by(make_png(2, 1, {0, 0, 0, 1}, {.bits = 16})), "01") << "one in 65535, a label";
    const Bytes cut_out = make_png(3, 1, {9, 0, 9, 255, 0, 255}, {.colour_type = 4});
    EXPECT_EQ(kept_by(cut_out), "010") << "the first is transparent";
    EXPECT_EQ(kept_by(cut_out, {.inverted = true}), "001");
    EXPECT_EQ(kept_by(make_npy("|b1", 3, 1, {1, 0, 1})), "101");
    const float none = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(kept_by(make_npy("<f4", 4, 1, bytes_of(std::vector<float>{none, 0.1f, 0, -1}))), "0101");
    EXPECT_CONTAINS(error_of([] { kept_by(make_png(2, 1, {0, 0}, {})); }), "leaves no pixel");
    EXPECT_CONTAINS(error_of([] { kept_by(to_bytes("no picture at all")); }), "cannot read");
}

TEST(Mask, WhatCompressionLeftBesideItsEdgesIsNone) {
    Bytes half(256, 0);
    for (int i = 0; i < 256; ++i) half[i] = i % 16 < 5 ? 0 : 255;
    std::string row = "00000" + std::string(11, '1'), all;
    for (int y = 0; y < 16; ++y) all += row;
    EXPECT_EQ(kept_by(make_jpeg(16, 16, half, JpegKind::grey)), all);
}

TEST(Mask, OfAFileWithSeveralArraysIsRefused) {
    const Bytes array = make_npy("|b1", 1, 1, {1}),
                two = make_zip({{"a.npy", array}, {"b.npy", array}}, false);
    EXPECT_CONTAINS(error_of([&] { kept_by(two); }), "give a file that has one alone: a, b");
    EXPECT_CONTAINS(error_of([&] { kept_above(two, 0.5); }), "name one by input.confidence.key: a, b");
}

TEST(Confidence, IntegersAreSharesOfTheirLargestAndLevelsOfTwo) {
    EXPECT_EQ(kept_above(make_png(4, 1, {0, 1, 2, 1}, {}), 0.5), "0111") << "ARKit's levels";
    EXPECT_EQ(kept_above(make_png(4, 1, {0, 1, 2, 1}, {}), 1), "0010");
    EXPECT_EQ(kept_above(make_png(4, 1, {0, 127, 128, 255}, {}), 0.5), "0011");
    EXPECT_EQ(kept_above(make_npy("<u2", 3, 1, bytes_of(std::vector<std::uint16_t>{100, 40000, 65535})), 0.6),
              "011");
    const float none = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(kept_above(make_npy("<f4", 4, 1, bytes_of(std::vector<float>{none, 0.4f, 0.5f, 7})), 0.5),
              "0011");
    EXPECT_CONTAINS(error_of([] {
                        kept_above(make_png(2, 1, {9, 99}, {}), 0.9);
                    }),
                    "below input.confidence.threshold");
}

TEST(Mask, AnotherSizeTakesWhatLiesUnderEachCentre) {
    const PixelMask mask{2, 2, {1, 0, 0, 1}};
    EXPECT_EQ(kept_text(resampled(mask, 4, 4)), "1100110000110011");
    EXPECT_EQ(kept_text(resampled(mask, 3, 2)), "100011");
    EXPECT_EQ(kept_text(resampled(resampled(mask, 8, 8), 2, 2)), "1001");
}

}  // namespace
}  // namespace hexrelief::readers
