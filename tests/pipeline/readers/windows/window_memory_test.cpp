// Tests the memory that a process needs to read windows of much larger maps.
#include "pipeline/readers/windows/map_windows.h"
#include "pipeline/readers/windows/map_writer.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

namespace fs = std::filesystem;

TEST(MapWindows, TakeTheMemoryOfAWindow) {
    const Folder folder;
    const fs::path rows = folder.write("map.raw", ""), tiles = folder.path() / "map.tif";
    fs::resize_file(rows, std::uintmax_t{4} << 30);  // a sparse file
    {
        exporters::FileTransaction files;
        MapWriter writer(files, tiles, 4096, 4096);
        const std::vector<float> row(4096, 5.0f);
        for (int y = 0; y < 4096; ++y) writer.write(row.data(), 1);
        writer.finish();
        files.commit();
    }
    const auto read_diagonal = [](const MapWindows& map) {
        for (int i = 0; i < 8; ++i) map.read(map.width() / 8 * i, map.height() / 8 * i, 512, 512);
    };
    const long least = peak_memory_MiB([] {});
    const MapWindowConfig raw{.raw = parse_raw_map_layout("32768x32768,float32")};
    EXPECT_LT(peak_memory_MiB([&] { read_diagonal(*MapWindows::open(rows, raw)); }), least + 8);
    EXPECT_LT(peak_memory_MiB([&] { read_diagonal(*MapWindows::open(tiles)); }), least + 12);
}

TEST(PictureWindows, TakeTheMemoryOfAWindow) {
    const Folder folder;
    // Above the limit for pictures read as a whole.
    const fs::path rows = folder.write("p.ppm", "P6\n40000 30000\n255\n");
    fs::resize_file(rows, fs::file_size(rows) + std::uintmax_t{3} * 40000 * 30000);
    // Small windows, because sanitizers keep freed memory for a while.
    const auto read_diagonal = [&] {
        const auto picture = PictureWindows::open(rows);
        for (int i = 0; i < 8; ++i) picture->read(picture->width() / 8 * i, 3000 * i, 256, 256);
    };
    const long least = peak_memory_MiB([] {});
    EXPECT_LT(peak_memory_MiB(read_diagonal), least + 8);
}

}  // namespace
}  // namespace hexrelief::readers
