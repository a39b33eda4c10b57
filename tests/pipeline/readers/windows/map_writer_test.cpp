#include "pipeline/readers/windows/map_writer.h"

#include <algorithm>
#include <iterator>

#include "pipeline/readers/windows/map_windows.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

namespace fs = std::filesystem;

DisparityMap sample_map(int width, int height) {
    DisparityMap map{width, height, {}};
    for (int i = 0; i < width * height; ++i)
        map.values.push_back(i % 7 == 3 ? kUnknownDisparity : 1.0f + static_cast<float>(i) / 3);
    return map;
}

void write_map(const fs::path& path, const DisparityMap& map, int tile_px, int rows_at_once) {
    exporters::FileTransaction files;
    MapWriter writer(files, path, map.width, map.height, tile_px);
    for (int y = 0; y < map.height; y += rows_at_once)
        writer.write(&map.values[static_cast<std::size_t>(y) * map.width],
                     std::min(rows_at_once, map.height - y));
    writer.finish();
    EXPECT_FALSE(fs::exists(path));
    files.commit();
}

TEST(MapWriter, MapsAreReadBack) {
    for (const auto& [width, height] :
         std::vector<std::pair<int, int>>{{1, 1}, {37, 29}, {64, 32}, {5, 70}}) {
        const DisparityMap map = sample_map(width, height);
        for (const int tile : {1, 7, 16, 256})
            for (const char* const name : {"map.tif", "map.tiff", "map.pfm"}) {
                SCOPED_TRACE(std::string(name) + " " + std::to_string(width) + " tile " +
                             std::to_string(tile));
                const Folder folder;
                const fs::path path = folder.path() / name;
                write_map(path, map, tile, tile == 7 ? 4 : 9);
                EXPECT_EQ(read_disparity_map(path, {}).values, map.values);
                const auto windows = MapWindows::open(path);
                EXPECT_EQ(windows->read(0, 0, width, height).values, map.values);
                EXPECT_EQ(windows->read(width / 2, height / 2, 1, 1).values[0],
                          map.at(width / 2, height / 2));
            }
    }
}

TEST(MapWriter, LeavesNothingWithoutCommit) {
    const Folder folder;
    folder.write("map.pfm", "old");
    {
        exporters::FileTransaction files;
        MapWriter writer(files, folder.path() / "map.pfm", 2, 2);
        const float row[2] = {1, 2};
        writer.write(row, 1);
    }
    EXPECT_EQ(read_bytes(folder.path() / "map.pfm"), to_bytes("old"));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(MapWriter, RefusesOtherNamesAndSizes) {
    const Folder folder;
    exporters::FileTransaction files;
    const auto failure = [&](const char* name, int width, int height, ErrorKind kind) {
        return error_of([&] { MapWriter(files, folder.path() / name, width, height); }, kind);
    };
    EXPECT_CONTAINS(failure("map.png", 2, 2, ErrorKind::usage), ".pfm");
    EXPECT_CONTAINS(failure("map.tif", 0, 2, ErrorKind::usage), "not 0x2");
    EXPECT_CONTAINS(failure("map.tif", 2, kLargestMapSide_px + 1, ErrorKind::usage), "1 to 8388608");
    EXPECT_CONTAINS(failure("none/map.tif", 2, 2, ErrorKind::output), "cannot write");
    fs::create_symlink("/dev/full", folder.path() / "full.pfm");
    EXPECT_CONTAINS(failure("full.pfm", 2, 2, ErrorKind::output), "no regular file");
}

}  // namespace
}  // namespace hexrelief::readers
