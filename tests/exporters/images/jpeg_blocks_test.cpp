// Tests that a JPEG texture keeps what the file that it comes from has.
#include "exporters/images/jpeg_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>

#include "exporters/images/image_writer.h"
#include "exporters/images/texture.h"
#include "pipeline/data/crop.h"
#include "tests/exporters/sample_scene.h"
#include "tests/libjpeg.h"

namespace hexrelief::exporters {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Kind {
    int channels, sampling;  // sampling 2: the colours have half the columns and rows
    bool progressive;
};

// With a comment of 1,000 bytes.
Bytes encoded(const Image& image, const Kind& kind, int quality) {
    Bytes file = test::encoded_by_libjpeg(image, [&](jpeg_compress_struct& jpeg) {
        jpeg_set_quality(&jpeg, quality, TRUE);
        jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = kind.sampling;
        if (kind.progressive) jpeg_simple_progression(&jpeg);
    });
    Bytes comment(1004, 'x');
    std::copy_n(std::begin({0xff, 0xfe, 1002 >> 8, 1002 & 255}), 4, comment.begin());
    file.insert(file.begin() + 2, comment.begin(), comment.end());
    return file;
}

Image decoded(const Bytes& bytes) {
    return test::decoded_by_libjpeg(bytes).image;
}

// A picture without smooth parts, which no coder keeps by chance.
Image rough_picture(int width, int height, int channels) {
    Image image{width, height, channels, {}};
    std::uint32_t state = 1;
    for (int i = 0; i < width * height * channels; ++i) {
        state = state * 1664525u + 1013904223u;
        image.pixels.push_back(static_cast<std::uint8_t>(64 + (state >> 25) + (i / 40) % 60));
    }
    return image;
}

PixelRect whole(const Image& image) {
    return {0, 0, image.width, image.height};
}

class JpegBlocks : public testing::TestWithParam<Kind> {
  protected:
    const Bytes source_ = encoded(rough_picture(83, 61, GetParam().channels), GetParam(), 70);
    const Image picture_ = decoded(source_);
};

TEST_P(JpegBlocks, ThePictureOfAFileStaysAsItIs) {
    const Bytes kept = encode_jpeg_as(source_, picture_, whole(picture_)).bytes;
    ASSERT_FALSE(kept.empty());
    EXPECT_EQ(decoded(kept).pixels, picture_.pixels);
    EXPECT_LT(kept.size() + 1000, source_.size() + 30) << "its comment is not kept";
}

TEST_P(JpegBlocks, APartFromWholeBlocksStaysAsItIs) {
    const PixelRect part{32, 16, 40, 33};
    const Image kept = decoded(encode_jpeg_as(source_, picture_, part).bytes);
    ASSERT_EQ(kept.width, part.width);
    ASSERT_EQ(kept.height, part.height);
    // Halved colours are interpolated across the border of the part, which is then another one.
    const int border = GetParam().sampling - 1;
    for (int y = border; y < part.height - border; ++y)
        for (int x = border; x < part.width - border; ++x)
            for (int c = 0; c < kept.channels; ++c)
                ASSERT_EQ(kept.at(x, y)[c], picture_.at(part.x + x, part.y + y)[c]) << x << ' ' << y;
}

TEST_P(JpegBlocks, APictureMayGoOnBelow) {
    const int below = 64;  // the next whole block
    Image atlas = rough_picture(picture_.width, below + 24, picture_.channels);
    std::copy(picture_.pixels.begin(), picture_.pixels.end(), atlas.pixels.begin());
    const Image kept = decoded(encode_jpeg_as(source_, atlas, whole(atlas)).bytes);
    ASSERT_EQ(kept.height, atlas.height);
    const auto rows = [&](int count) { return count * picture_.width * picture_.channels; };
    const int same = picture_.height - (GetParam().sampling - 1);
    EXPECT_TRUE(std::equal(kept.pixels.begin(), kept.pixels.begin() + rows(same), picture_.pixels.begin()));
    double error = 0;
    for (int i = rows(below); i < rows(below + 24); ++i) error += std::abs(kept.pixels[i] - atlas.pixels[i]);
    EXPECT_LT(error / rows(24), 30) << "what is below is encoded";
}

TEST_P(JpegBlocks, AnotherPictureIsEncodedLikeTheFile) {
    Image other = picture_;
    for (std::uint8_t& value : other.pixels) value = static_cast<std::uint8_t>(255 - value);
    const Image kept = decoded(encode_jpeg_as(source_, other, whole(other)).bytes);
    double error = 0;
    for (std::size_t i = 0; i < other.pixels.size(); ++i) error += std::abs(kept.pixels[i] - other.pixels[i]);
    EXPECT_LT(error / static_cast<double>(other.pixels.size()), 30);
}

INSTANTIATE_TEST_SUITE_P(Kinds, JpegBlocks,
                         testing::Values(Kind{3, 1, false}, Kind{3, 2, false}, Kind{3, 2, true},
                                         Kind{1, 1, false}, Kind{1, 2, false}, Kind{1, 4, false}));

TEST(JpegBlocks, OtherFilesGiveNothing) {
    const Image grey = rough_picture(40, 30, 1), color = rough_picture(40, 30, 3);
    Bytes jpeg = encode_jpeg(color, 80);
    EXPECT_TRUE(encode_jpeg_as({}, color, whole(color)).bytes.empty());
    EXPECT_TRUE(encode_jpeg_as(encode_png(color), color, whole(color)).bytes.empty());
    EXPECT_TRUE(encode_jpeg_as(jpeg, grey, whole(grey)).bytes.empty());
    const Image blurred = decoded(jpeg);
    jpeg.resize(jpeg.size() - 40);  // within its last row of blocks
    EXPECT_TRUE(encode_jpeg_as(jpeg, blurred, {0, 0, 40, 16}).bytes.empty());
}

TEST(JpegBlocks, ATextureTakesNoMoreBytesThanItsFile) {
    const Bytes file = encoded(rough_picture(96, 64, 3), {3, 2, false}, 60);
    const Image picture = decoded(file);
    const SurfaceMesh mesh = sample_mesh(8, 6);
    Scene scene{&mesh, &picture, "", ""};
    ExportConfig config;
    const auto texture = [&] { return encode_texture(scene, textured_mesh(scene, config), config).bytes; };
    const std::size_t anew = texture().size();
    scene.texture_file = &file;
    EXPECT_LT(texture().size(), std::min(anew, file.size()));
    EXPECT_EQ(decoded(texture()).pixels, picture.pixels);
    config.texture_quality = 10;  // the file would be larger
    EXPECT_EQ(texture(), encode_jpeg(picture, 10));
}

}  // namespace
}  // namespace hexrelief::exporters
