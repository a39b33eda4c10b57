// Tests windows of pictures against crops of read_image()'s pictures.
#include "pipeline/readers/windows/map_windows.h"

#include <algorithm>
#include <array>
#include <random>
#include <thread>

#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

namespace fs = std::filesystem;
constexpr int kWidth_px = 53, kHeight_px = 39;

Bytes random_bytes(std::size_t count) {
    std::mt19937 random(5);
    Bytes bytes(count);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    return bytes;
}

void expect_crop(const Image& window, const Image& whole, int x, int y) {
    ASSERT_EQ(window.channels, whole.channels);
    ASSERT_EQ(window.pixels.size(), static_cast<std::size_t>(window.width) * window.height * window.channels);
    const auto alpha_at = [](const Image& image, int column, int row) {
        return image.alpha[static_cast<std::size_t>(row) * image.width + column];
    };
    bool is_opaque = true;
    for (int row = 0; row < window.height; ++row)
        for (int column = 0; column < window.width; ++column) {
            ASSERT_TRUE(std::equal(window.at(column, row), window.at(column, row) + window.channels,
                                   whole.at(x + column, y + row)))
                << x + column << "," << y + row;
            if (whole.alpha.empty()) continue;
            is_opaque = is_opaque && alpha_at(whole, x + column, y + row) >= kOpaque;
            if (!window.alpha.empty()) {
                ASSERT_EQ(alpha_at(window, column, row), alpha_at(whole, x + column, y + row));
            }
        }
    EXPECT_EQ(window.alpha.empty(), is_opaque);
}

// Checks the whole picture, its corner, and windows anywhere.
void expect_windows(const fs::path& path) {
    const Image whole = read_image(path);
    const auto windows = PictureWindows::open(path);
    ASSERT_EQ(windows->width(), whole.width);
    ASSERT_EQ(windows->height(), whole.height);
    ASSERT_EQ(windows->channels(), whole.channels);
    expect_crop(windows->read(0, 0, whole.width, whole.height), whole, 0, 0);
    expect_crop(windows->read(whole.width - 1, whole.height - 1, 1, 1), whole, whole.width - 1,
                whole.height - 1);
    std::mt19937 random(11);
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    for (int i = 0; i < 8; ++i) {
        const int x = below(whole.width), y = below(whole.height);
        expect_crop(windows->read(x, y, 1 + below(whole.width - x), 1 + below(whole.height - y)), whole, x,
                    y);
    }
}

TEST(PictureWindows, OfTiffsAreCropsOfTheWholePicture) {
    const Folder folder;
    const Bytes rows = random_bytes(std::size_t{8} * kWidth_px * kHeight_px);
    for (const int bits : {8, 16})
        for (const int tile : {0, 16, 64})
            for (const int compression : {1, 5, 8})
                for (const int samples : {1, 2, 3, 4})
                    for (const bool is_other : {false, true}) {
                        TiffKind kind{.samples = samples,
                                      .bits = bits,
                                      .photometric = samples >= 3               ? 2
                                                     : is_other && samples == 1 ? 0
                                                                                : 1,
                                      .compression = compression,
                                      .tile = tile,
                                      .planes = is_other && samples > 1,
                                      .big_endian = is_other};
                        SCOPED_TRACE(std::to_string(samples) + " samples of " + std::to_string(bits) +
                                     " bits, tile " + std::to_string(tile) + ", compression " +
                                     std::to_string(compression) + (is_other ? ", planes" : ""));
                        expect_windows(folder.write("p.tif", make_tiff(kWidth_px, kHeight_px, rows, kind)));
                    }
}

TEST(PictureWindows, OfTiffsOfFewBitsAndOfPalettes) {
    const Folder folder;
    for (const int bits : {1, 2, 4}) {
        const Bytes rows = random_bytes(static_cast<std::size_t>((kWidth_px * bits + 7) / 8) * kHeight_px);
        expect_windows(folder.write("p.tif", make_tiff(kWidth_px, kHeight_px, rows, {.bits = bits})));
    }
    const Bytes rows = random_bytes(std::size_t{4} * kWidth_px * kHeight_px);
    expect_windows(folder.write("p.tif", make_tiff(kWidth_px, kHeight_px, rows, {.photometric = 3})));
    expect_windows(
        folder.write("p.tif", make_tiff(kWidth_px, kHeight_px, rows, {.samples = 4, .photometric = 5})));
}

TEST(PictureWindows, OfPnmsAndOfPicturesHeldAsAWhole) {
    const Folder folder;
    for (const int most : {1, 100, 255, 1023, 65535})
        for (const int channels : {1, 3}) {
            const std::size_t count = std::size_t{kWidth_px} * kHeight_px * channels * (most > 255 ? 2 : 1);
            expect_windows(folder.write("p.pnm", make_pgm(kWidth_px, kHeight_px, most, random_bytes(count),
                                                          channels == 3 ? '6' : '5')));
        }
    const std::size_t pixels = std::size_t{kWidth_px} * kHeight_px;
    for (const auto& [type, samples] : std::vector<std::pair<int, int>>{{0, 1}, {2, 3}, {4, 2}, {6, 4}})
        expect_windows(folder.write(
            "p.png", make_png(kWidth_px, kHeight_px, random_bytes(pixels * samples), {.colour_type = type})));
    expect_windows(
        folder.write("p.jpg", make_jpeg(kWidth_px, kHeight_px, random_bytes(3 * pixels), JpegKind::rgb)));
}

TEST(PictureWindows, ServeSeveralThreads) {
    const Folder folder;
    const fs::path path =
        folder.write("p.tif", make_tiff(150, 130, random_bytes(3 * 150 * 130),
                                        {.samples = 3, .photometric = 2, .compression = 8, .tile = 16}));
    const Image whole = read_image(path);
    const auto windows = PictureWindows::open(path);
    std::vector<int> wrong(4, 0);
    std::vector<std::thread> threads;
    for (unsigned thread = 0; thread < 4; ++thread)
        threads.emplace_back([&, thread] {
            std::mt19937 random(thread);
            for (int i = 0; i < 50; ++i) {
                const int x = static_cast<int>(random() % 100), y = static_cast<int>(random() % 100);
                const Image window = windows->read(x, y, 50, 30);
                for (int row = 0; row < 30; ++row)
                    wrong[thread] +=
                        !std::equal(window.at(0, row), window.at(0, row) + 150, whole.at(x, y + row));
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(PictureWindows, OutsideOfThePictureAreRefused) {
    const Folder folder;
    for (const fs::path& path : {folder.write("p.pgm", make_pgm(3, 2, 255, Bytes(6, 1))),
                                 folder.write("p.png", make_png(3, 2, Bytes(6, 1), {}))}) {
        const auto windows = PictureWindows::open(path);
        for (const auto& w : std::vector<std::array<int, 4>>{
                 {0, 0, 4, 1}, {0, 0, 1, 3}, {-1, 0, 1, 1}, {0, 0, 0, 1}, {0, 0, 1, -1}, {3, 0, 1, 1}})
            EXPECT_CONTAINS(error_of([&] { windows->read(w[0], w[1], w[2], w[3]); }), "there is no window");
    }
}

TEST(PictureWindows, DamagedFilesAreRefused) {
    const Folder folder;
    const auto open_error = [&](const Bytes& bytes) {
        return error_of([&] { PictureWindows::open(folder.write("bad", bytes)); });
    };
    EXPECT_CONTAINS(error_of([&] { PictureWindows::open(folder.path() / "none"); }), "no such file");
    EXPECT_CONTAINS(error_of([&] { PictureWindows::open(folder.path()); }), "folder");
    EXPECT_CONTAINS(open_error({}), "empty");
    EXPECT_CONTAINS(open_error(to_bytes("Pf\n1 1\n-1\n") + Bytes(4, 0)), "is a map, not an image");
    EXPECT_CONTAINS(open_error(make_tiff(4, 4, Bytes(64, 0), {.bits = 32, .format = 3})), "is a map");
    EXPECT_CONTAINS(open_error(make_tiff(4, 4, Bytes(32, 0), {.bits = 16, .format = 2})), "signed");
    EXPECT_CONTAINS(open_error(to_bytes("P5\n99999999 4\n255\n")), "px a side");
    EXPECT_CONTAINS(open_error(to_bytes("P6\n4000000 4000000\n255\n")), "truncated");
    EXPECT_CONTAINS(open_error(to_bytes("P5\n4 0\n255\n")), "at least 1");
    EXPECT_CONTAINS(open_error(to_bytes("P5\n4 4\n70000\n")), "maxval");

    const Bytes rows(std::size_t{3} * 64 * 64, 9);
    for (const int tile : {0, 16})
        for (const int compression : {1, 8}) {
            const Bytes whole = make_tiff(
                64, 64, rows, {.samples = 3, .photometric = 2, .compression = compression, .tile = tile});
            EXPECT_CONTAINS(open_error(Bytes(whole.begin(), whole.begin() + whole.size() / 2)), "malformed");
        }
    Bytes lying = make_tiff(16, 16, Bytes(256, 9), {.compression = 8, .tile = 16});
    std::fill_n(lying.begin() + 8, 12, 0xff);
    const auto windows = PictureWindows::open(folder.write("bad", lying));
    EXPECT_CONTAINS(error_of([&] { windows->read(0, 0, 16, 16); }), "malformed");
}

// Files whose ends are cut off after they have been opened.
TEST(PictureWindows, FilesThatShrinkAreRefused) {
    const Folder folder;
    const fs::path path = folder.write("p.ppm", make_pgm(10, 10, 255, Bytes(300, 1), '6'));
    const auto windows = PictureWindows::open(path);
    fs::resize_file(path, fs::file_size(path) - 150);
    EXPECT_NO_THROW(windows->read(0, 0, 10, 5));
    EXPECT_CONTAINS(error_of([&] { windows->read(0, 0, 10, 6); }), "ends within row 5");
}

}  // namespace
}  // namespace hexrelief::readers
