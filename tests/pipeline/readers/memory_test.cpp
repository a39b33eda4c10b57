// Tests files of a few bytes that claim hundreds of megapixels.
#include <zlib.h>

#include <array>

#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

// Returns a TIFF with one strip that claims a picture of this size and holds 20 zeros.
Bytes empty_tiff(std::uint32_t side, std::uint32_t compression, bool inks) {
    const std::vector<std::array<std::uint32_t, 2>> tags = {
        {256, side},           {257, side},           {258, 8},
        {259, compression},    {262, inks ? 5u : 1u}, {273, 8 + 2 + 108 + 4},
        {277, inks ? 4u : 1u}, {278, side},           {279, 20}};
    Bytes file = to_bytes(std::string_view("II*\0\x08\0\0\0\x09\0", 10));
    for (const auto& [tag, value] : tags)
        file = file + bytes_of(std::vector<std::uint16_t>{static_cast<std::uint16_t>(tag), 4, 1, 0}) +
               bytes_of(std::vector<std::uint32_t>{value});
    return file + Bytes(4 + 20, 0);
}

// Returns the peak memory, in MiB, of a process that refuses the file.
long peak_MiB(const Bytes& file) {
    const Folder folder;
    const auto path = folder.write("bad.bin", file);
    return peak_memory_MiB([&] { error_of([&] { read_image(path); }); });
}

TEST(ReadTiff, HeadersAloneTakeNoMemory) {
    const long least = peak_MiB({});
    for (const std::uint32_t compression : {34925, 50000, 7, 34887, 50001, 32909})
        for (const bool inks : {false, true})
            EXPECT_LT(peak_MiB(empty_tiff(23000, compression, inks)), least + 300) << compression << inks;
}

TEST(ReadWebp, HeadersAloneTakeNoMemory) {
    // Lossless, 16383 x 16383 px, all codes of zero bits.
    const Bytes file = to_bytes(
        std::string_view("RIFF\x1a\0\0\0WEBPVP8L\x0e\0\0\0\x2f\xfe\xbf\xff\x0f\0\0\0\0\0\0\0\0\0", 34));
    EXPECT_LT(peak_MiB(file), peak_MiB({}) + 300);
}

TEST(ReadJpeg, RowsThatAreNotThereTakeNoMemory) {
    // Two rows of blocks, in a header that promises 16384 x 16384 pixels.
    Bytes file = make_jpeg(16384, 16, Bytes(16384 * 16 * 3, 100), JpegKind::rgb);
    for (std::size_t i = 0; i + 9 < file.size(); ++i)
        if (file[i] == 0xff && file[i + 1] == 0xc0) file[i + 5] = 0x40, file[i + 6] = 0;
    EXPECT_LT(peak_MiB(file), peak_MiB({}) + 100);
    file.resize(600000);  // as long as such a picture may be
    EXPECT_LT(peak_MiB(file), peak_MiB({}) + 100);
}

TEST(ReadJpeg, AProgressiveHeaderTakesNoMemory) {
    Bytes file = make_jpeg(16384, 16, Bytes(16384 * 16 * 3, 100), JpegKind::rgb_progressive);
    for (std::size_t i = 0; i + 9 < file.size(); ++i)
        if (file[i] == 0xff && file[i + 1] == 0xc2) file[i + 5] = 0x40, file[i + 6] = 0;
    file.resize(65000);
    EXPECT_LT(peak_MiB(file), peak_MiB({}) + 100);
}

TEST(ReadPng, RowsThatAreNotThereTakeNoMemory) {
    Bytes file = make_png(16384, 64, Bytes(16384 * 64, 100), {});
    file[22] = 0x40, file[23] = 0;  // 16384 rows
    const auto sum = static_cast<std::uint32_t>(crc32(0, file.data() + 12, 17));
    for (std::size_t i = 0; i < 4; ++i) file[29 + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
    file.resize(file.size() + 300000);
    EXPECT_LT(peak_MiB(file), peak_MiB({}) + 100);
}

}  // namespace
}  // namespace hexrelief::readers
