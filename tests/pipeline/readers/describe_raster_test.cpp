#include "pipeline/readers/decoded_raster.h"

#include <fstream>
#include <sstream>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

void expect_description(const Bytes& bytes, const std::string& format, int channels, int bits) {
    const Folder folder;
    const auto found = describe_raster(folder.write("file", bytes));
    ASSERT_TRUE(found.has_value()) << format;
    EXPECT_EQ(found->format, format);
    EXPECT_EQ(found->width, 4) << format;
    EXPECT_EQ(found->height, 2) << format;
    EXPECT_EQ(found->channels, channels) << format;
    EXPECT_EQ(found->bits, bits) << format;
}

TEST(DescribeRaster, TellsEveryFormat) {
    expect_description(make_png(4, 2, Bytes(64, 1), {.bits = 16, .colour_type = 6}), "png", 4, 16);
    expect_description(make_png(4, 2, {1, 2}, {.bits = 2}), "png", 1, 2);
    expect_description(make_png(4, 2, {1, 2}, {.bits = 2, .colour_type = 3, .palette = Bytes(12)}), "png", 3,
                       8);
    expect_description(make_pgm(4, 2, 255, Bytes(8)), "pgm", 1, 8);
    expect_description(make_pgm(4, 2, 1000, Bytes(48), '6'), "ppm", 3, 16);
    expect_description(make_pfm(4, 2, std::vector<float>(8)), "pfm", 1, 32);
    expect_description(make_jpeg(4, 2, Bytes(24), JpegKind::rgb), "jpeg", 3, 8);
    expect_description(make_webp(4, 2, Bytes(32, 255), true), "webp", 3, 8);
    expect_description(make_tiff(4, 2, Bytes(32), {.bits = 32, .format = 3}), "tiff", 1, 32);
}

// A PFM of the right size, a ZIP archive and a photograph of which all but the first bytes are missing.
TEST(DescribeRaster, HollowFilesAreNotLoaded) {
    const Folder folder;
    constexpr std::uintmax_t large = std::uintmax_t{4} << 30;
    const std::string head = "Pf\n16384 16384\n-1\n";
    const auto pfm = folder.write("a.pfm", to_bytes(head));
    std::filesystem::resize_file(pfm, head.size() + (std::uintmax_t{1} << 30));
    const auto npz = folder.write("a.npz", to_bytes(std::string("PK\3\4") + std::string(60, 'x')));
    const auto heic = folder.write("a.heic", to_bytes(std::string("\0\0\0\x10"
                                                                  "ftypheic\0\0\0\0",
                                                                  16)));
    for (const auto& file : {npz, heic}) std::filesystem::resize_file(file, large);
    EXPECT_CONTAINS(error_of([&] { read_disparity_map(pfm, {}); }), "it is hollow: of its");
    EXPECT_CONTAINS(error_of([&] { describe_raster(npz); }), "are on the disk");
    EXPECT_CONTAINS(error_of([&] { describe_raster(heic); }), "are on the disk");
}

TEST(DescribeRaster, GivesNothingForOtherFiles) {
    const Folder folder;
    EXPECT_FALSE(describe_raster(folder.write("a.txt", "cam0=[1 0 0; 0 1 0; 0 0 1]\n")));
    EXPECT_FALSE(describe_raster(folder.write("a.glb", "glTF....")));
    EXPECT_FALSE(describe_raster(folder.write("empty", "")));
    EXPECT_FALSE(describe_raster(folder.write("P5text", "P5s are fine cameras\n")));
}

TEST(DescribeRaster, RefusesWhatIsAboveTheLimitByItsHeader) {
    const Folder folder;
    const ReaderLimits limits{8, "--most"};
    EXPECT_TRUE(describe_raster(folder.write("fits", make_pgm(4, 2, 255, Bytes(8))), {}, limits));
    // None of these decoders would accept these bytes as samples.
    for (const Bytes& bytes : {make_pgm(3, 3, 255, {}), make_pfm(3, 3, {}), make_png(3, 3, Bytes(9), {}),
                               make_jpeg(3, 3, Bytes(9), JpegKind::grey),
                               make_webp(3, 3, Bytes(36, 255), true), make_tiff(3, 3, Bytes(9), {})}) {
        const auto file = folder.write("large", bytes);
        const std::string error = error_of([&] { describe_raster(file, {}, limits); });
        EXPECT_CONTAINS(error, "large': its size is 3x3, more than the limit of 8 pixels (--most); ");
        EXPECT_CONTAINS(error, "or raise the limit");
    }
}

TEST(DescribeRaster, ReadsTheHeadAlone) {
    constexpr std::uintmax_t large = std::uintmax_t{8} << 30;  // more than is ever read whole
    const Folder folder;
    for (const Bytes& bytes : {make_pgm(4, 2, 255, Bytes(8)), make_pfm(4, 2, std::vector<float>(8)),
                               make_png(4, 2, Bytes(8), {}), make_jpeg(4, 2, Bytes(8), JpegKind::grey),
                               make_webp(4, 2, Bytes(32, 255), true), make_tiff(4, 2, Bytes(8), {})}) {
        const auto file = folder.write("large", bytes);
        std::filesystem::resize_file(file, large);
        const auto found = describe_raster(file);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->width, 4) << found->format;
    }
}

TEST(DescribeRaster, FindsTheSizeBehindMetadata) {
    // Ten application segments of 65 kB before the rest of a JPEG.
    const Bytes jpeg = make_jpeg(4, 2, Bytes(8), JpegKind::grey);
    Bytes file(jpeg.begin(), jpeg.begin() + 2);
    for (int i = 0; i < 10; ++i) file = file + Bytes{0xff, 0xe5, 0xff, 0xff} + Bytes(65533, 0);
    file = file + Bytes(jpeg.begin() + 2, jpeg.end());
    const Folder folder;
    const auto found = describe_raster(folder.write("metadata.jpg", file));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->width, 4);
}

TEST(DescribeRaster, RefusesMissingFilesAndMalformedHeaders) {
    const Folder folder;
    EXPECT_CONTAINS(error_of([&] { describe_raster(folder.path() / "none"); }), "no such file");
    EXPECT_CONTAINS(error_of([&] { describe_raster(folder.write("bad", "P5\nx")); }), "width");
}

TEST(DescribeRaster, ThePageOfFormatsFollowsTheTable) {
    std::ifstream file(HEXRELIEF_SOURCE_DIR "/exporters/FORMATS.md");
    std::stringstream page;
    page << file.rdbuf();
    std::string rows = "| format | names | picture | both views | map | camera | confidence |\n";
    rows += "| --- | --- | --- | --- | --- | --- | --- |\n";
    for (const codec::Codec& codec : codec::codecs()) {
        rows += "| " + std::string(codec.name) + " | " + std::string(codec.endings) + " |";
        for (const unsigned one :
             {codec::kPicture, codec::kBothViews, codec::kMap, codec::kCamera, codec::kConfidence})
            rows += (codec.gives & one) != 0 ? " yes |" : " |";
        rows += "\n";
    }
    EXPECT_CONTAINS(page.str(), "\n" + rows + "\n") << "write FORMATS.md anew as this:\n" << rows;
    const Folder folder;
    const auto text = folder.write("a.txt", "1,2,3\n");
    EXPECT_CONTAINS(error_of([&] { read_image(text); }), codec::names_of(codec::kPicture));
    EXPECT_CONTAINS(error_of([&] { read_disparity_map(text, {}); }), codec::names_of(codec::kMap));
    EXPECT_CONTAINS(error_of([&] { read_confidence(text, {}); }), codec::names_of(codec::kConfidence));
    EXPECT_CONTAINS(error_of([&] { read_mask(text, {}); }), codec::names_of(codec::kPicture | codec::kMap));
    const auto jpeg = folder.write("a.jpg", make_jpeg(4, 2, Bytes(8), JpegKind::grey));
    EXPECT_CONTAINS(error_of([&] { read_disparity_map(jpeg, {}); }),
                    "JPEG does not keep disparities exactly; give a disparity map as one of " +
                        codec::names_of(codec::kMap));
}

}  // namespace
}  // namespace hexrelief::readers
