// Tests that JPEG files encoded in strips are those that libjpeg writes in one go.
#include "exporters/images/jpeg_encoder.h"

#include <gtest/gtest.h>

#include "pipeline/data/error.h"
#include "tests/libjpeg.h"

namespace hexrelief::exporters {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Encoded {
    int width, height, channels, across, down;  // sampling factors of the first component
    unsigned noise;
};

Bytes by_libjpeg(const Image& image, const JpegSettings& settings) {
    return test::encoded_by_libjpeg(image, [&](jpeg_compress_struct& jpeg) {
        settings.prepare(jpeg);
        jpeg.optimize_coding = TRUE;
    });
}

Image noisy_picture(const Encoded& kind) {
    Image image{kind.width, kind.height, kind.channels, {}};
    std::uint32_t state = 1;
    for (int y = 0; y < image.height; ++y)
        for (int i = 0; i < image.width * image.channels; ++i) {
            state = state * 1664525u + 1013904223u;
            image.pixels.push_back(
                static_cast<std::uint8_t>(100 + y / 3 % 90 + (kind.noise ? (state >> 24) % kind.noise : 0)));
        }
    return image;
}

class JpegEncoder : public testing::TestWithParam<Encoded> {};

TEST_P(JpegEncoder, WritesTheBytesOfLibjpegWithAnyNumberOfThreads) {
    const Encoded& kind = GetParam();
    const Image image = noisy_picture(kind);
    for (const int quality : {30, 75, 100}) {
        const JpegSettings settings{[&](jpeg_compress_struct& jpeg) {
            jpeg_set_quality(&jpeg, quality, TRUE);
            jpeg.comp_info[0].h_samp_factor = kind.across;
            jpeg.comp_info[0].v_samp_factor = kind.down;
        }};
        const Bytes expected = by_libjpeg(image, settings);
        for (const int threads : {1, 3})
            EXPECT_EQ(encode_baseline_jpeg(image, {0, 0, image.width, image.height}, settings, threads),
                      expected)
                << "quality " << quality << ", threads " << threads;
    }
}

// Flat ones, of which several strips share a byte; noise, which has all symbols; incomplete units.
INSTANTIATE_TEST_SUITE_P(Kinds, JpegEncoder,
                         testing::Values(Encoded{1, 1, 1, 1, 1, 0}, Encoded{1, 1000, 1, 1, 1, 0},
                                         Encoded{5, 700, 3, 2, 2, 2}, Encoded{83, 261, 3, 1, 1, 20},
                                         Encoded{83, 261, 3, 2, 1, 40}, Encoded{83, 261, 3, 2, 2, 150},
                                         Encoded{40, 129, 1, 2, 2, 60}, Encoded{333, 200, 3, 1, 2, 8}));

TEST(JpegEncoder, APartIsEncodedAsAPictureOfItsOwn) {
    const Image image = noisy_picture({90, 150, 3, 1, 1, 60});
    const PixelRect part{13, 7, 50, 140};
    const JpegSettings settings{[](jpeg_compress_struct&) {}};
    EXPECT_EQ(encode_baseline_jpeg(image, part, settings, 2), by_libjpeg(cropped(image, part), settings));
}

TEST(JpegEncoder, RefusesCoefficientsThatAFileCannotHold) {
    const Image image = noisy_picture({40, 100, 3, 1, 1, 8});
    for (const int index : {0, 5})
        for (const JCOEF value : {JCOEF{1023}, JCOEF{-32768}}) {
            const auto replace = [&](int, JDIMENSION row, JBLOCKROW blocks, JDIMENSION) {
                if (row == 9) blocks[1][index] = value;
            };
            const JpegSettings settings{[](jpeg_compress_struct&) {}, replace};
            if (value > 0)
                EXPECT_NO_THROW(encode_baseline_jpeg(image, {0, 0, 40, 100}, settings, 2));
            else
                EXPECT_THROW(encode_baseline_jpeg(image, {0, 0, 40, 100}, settings, 2), Error);
        }
}

TEST(JpegEncoder, RefusesWhatAFileCannotHold) {
    const Image wide{65501, 1, 1, Bytes(65501)}, high{1, 65501, 1, Bytes(65501)};
    const JpegSettings settings{[](jpeg_compress_struct&) {}};
    for (const Image& image : {wide, high})
        EXPECT_THROW(encode_baseline_jpeg(image, {0, 0, image.width, image.height}, settings, 2), Error);
}

}  // namespace
}  // namespace hexrelief::exporters
