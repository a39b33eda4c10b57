#include "pipeline/readers/windows/terrain.h"

#include <algorithm>
#include <bit>

#include "pipeline/readers/windows/map_windows.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

std::vector<float> block(int x, int y, int width, int height, std::uint32_t seed) {
    std::vector<float> values(static_cast<std::size_t>(width) * height);
    for (int row = 0; row < height; ++row) terrain_row(x, y + row, width, seed, &values[row * width]);
    return values;
}

TEST(Terrain, IsTheSameInEveryCall) {
    const std::vector<float> whole = block(900, 1000, 300, 4, 5);
    for (int x = 0; x < 300; x += 50) {
        const std::vector<float> part = block(900 + x, 1002, 50, 1, 5);
        EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + 2 * 300 + x)) << x;
    }
    EXPECT_NE(block(900, 1000, 300, 4, 6), whole);
}

// FNV-1a of the bits, which are the same on every machine.
TEST(Terrain, HasTheseBits) {
    std::uint64_t sum = 0xcbf29ce484222325u;
    for (const int at : {0, 30000, kLargestMapSide_px - 64})
        for (const float value : block(at, at / 2, 64, 64, 1))
            sum = (sum ^ std::bit_cast<std::uint32_t>(value)) * 0x100000001b3u;
    EXPECT_EQ(sum, 6178759945169860278u);
}

TEST(Terrain, HasGroundRoofsAndHoles) {
    const std::vector<float> values = block(0, 0, 1024, 512, 3);
    std::size_t known = 0, flat = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!DisparityMap::known(values[i])) continue;
        ++known;
        flat += i > 0 && values[i] == values[i - 1];
        EXPECT_GE(values[i], 20);
        EXPECT_LE(values[i], 256);
    }
    EXPECT_GT(known, values.size() / 2);
    EXPECT_LT(known, values.size());
    EXPECT_GT(flat, known / 100);
    EXPECT_LT(flat, known / 4);
}

TEST(Terrain, FilesAreTheSameForAnyNumberOfThreads) {
    const readers::Folder folder;
    readers::Bytes first;
    for (const int threads : {1, 3}) {
        for (const char* const name : {"map.tif", "map.pfm"}) {
            exporters::FileTransaction files;
            MapWriter writer(files, folder.path() / name, 130, 70, 32);
            write_terrain(writer, 130, 70, 9, threads);
            writer.finish();
            files.commit();
        }
        const readers::Bytes bytes = readers::read_bytes(folder.path() / "map.tif");
        if (first.empty()) first = bytes;
        EXPECT_EQ(bytes, first);
        EXPECT_EQ(MapWindows::open(folder.path() / "map.tif")->read(0, 0, 130, 70).values,
                  MapWindows::open(folder.path() / "map.pfm")->read(0, 0, 130, 70).values);
    }
}

}  // namespace
}  // namespace hexrelief::readers
