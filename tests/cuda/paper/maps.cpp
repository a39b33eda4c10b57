#include "tests/cuda/paper/maps.h"

#include "pipeline/data/error.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::paper {
namespace {

const std::vector<PaperMap> kPaperMaps{
    {"tsukuba", "middlebury2001/tsukuba", 16, 3},     {"rocks1", "middlebury2006/rocks1-third", 3, 3},
    {"aloe", "middlebury2006/aloe-third", 3, 3},      {"venus", "middlebury2001/venus", 8, 3},
    {"teddy", "middlebury2003/teddy-quarter", 4, 3},  {"cones", "middlebury2003/cones-quarter", 4, 3},
    {"rocks1S", "middlebury2006/rocks1-third", 3, 4}, {"aloeS", "middlebury2006/aloe-third", 3, 4},
    {"conesS", "middlebury2003/cones-quarter", 4, 4}, {"teddyS", "middlebury2003/teddy-quarter", 4, 4},
    {"rocks1M", "middlebury2006/rocks1-half", 2, 4},  {"aloeM", "middlebury2006/aloe-half", 2, 4},
    {"conesM", "middlebury2003/cones-half", 2, 4},    {"teddyM", "middlebury2003/teddy-half", 2, 4},
    {"rocks1L", "middlebury2006/rocks1-full", 1, 4},  {"aloeL", "middlebury2006/aloe-full", 1, 4},
    {"conesL", "middlebury2003/cones-full", 1, 4},    {"teddyL", "middlebury2003/teddy-full", 1, 4}};

}  // namespace

std::vector<FoundMap> find_maps(const std::filesystem::path& data) {
    std::vector<FoundMap> found;
    for (const PaperMap& map : kPaperMaps)
        for (const char* name : {"disp.png", "disp.pgm"})
            if (const auto path = data / map.folder / name; std::filesystem::is_regular_file(path))
                found.push_back({map, path});
    if (found.empty())
        throw Error(ErrorKind::input, "--data " + data.string() +
                                          ": none of the paper's maps is there, such as " +
                                          kPaperMaps.front().folder + "/disp.pgm");
    return found;
}

DisparityMap load_map(const FoundMap& found) {
    readers::DisparityFileConfig file{.scale = found.map.scale};
    return readers::read_disparity_map(found.path, file);
}

}  // namespace hexrelief::paper
