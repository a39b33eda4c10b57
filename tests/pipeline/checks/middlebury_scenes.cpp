#include "middlebury_scenes.h"

#include <algorithm>

#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"

namespace hexrelief::checks::mistakes {
namespace {

namespace fs = std::filesystem;

constexpr SceneFiles kScenes[] = {
    {"middlebury2001/tsukuba", "left.png", "right.png", "disp.pgm", 16, 0, 0, 0},
    {"middlebury2001/venus", "left.ppm", "right.ppm", "disp.pgm", 8, 0, 0, 0},
    {"middlebury2003/teddy-quarter", "left.png", "right.png", "disp.png", 4, 0, 0, 0},
    {"middlebury2003/cones-quarter", "left.png", "right.png", "disp.png", 4, 0, 0, 0},
    {"middlebury2003/teddy-half", "left.ppm", "right.ppm", "disp.pgm", 2, 0, 0, 0},
    {"middlebury2003/cones-half", "left.ppm", "right.ppm", "disp.pgm", 2, 0, 0, 0},
    {"middlebury2003/teddy-full", nullptr, nullptr, "disp.pgm", 1, 0, 0, 0},
    {"middlebury2003/cones-full", "left.pgm", "right.pgm", "disp.pgm", 1, 0, 0, 0},
    {"middlebury2006/aloe-third", "left.png", "right.png", "disp.png", 3, 3740 / 3.0, 0.16, 90},
    {"middlebury2006/rocks1-third", "left.png", "right.png", "disp.png", 3, 3740 / 3.0, 0.16, 274 / 3.0},
    {"middlebury2006/aloe-half", "left.png", "right.png", "disp.png", 2, 1870, 0.16, 135},
    {"middlebury2006/rocks1-half", "left.png", "right.png", "disp.png", 2, 1870, 0.16, 137},
    {"middlebury2006/aloe-full", "left_color.jpg", "right_color.jpg", "disp.png", 1, 3740, 0.16, 270},
    {"middlebury2014-quarter/Piano", "left.png", "right.png", "disp.pfm", 1, 713.26, 0.178232, 0},
};

}  // namespace

std::vector<TestScene> load(const fs::path& data, const std::string& wanted) {
    std::vector<TestScene> scenes;
    for (const SceneFiles& files : kScenes) {
        const fs::path folder = data / files.folder;
        if (!fs::is_regular_file(folder / files.map)) continue;
        if (folder.string().find(wanted) == std::string::npos) continue;
        TestScene scene{&files, folder.filename().string(), {}, {}, 0};
        readers::DisparityFileConfig file{.scale = files.scale};
        scene.map = readers::read_disparity_map(folder / files.map, file);
        for (const float d : scene.map.values)
            if (DisparityMap::known(d)) scene.largest_px = std::max(scene.largest_px, static_cast<double>(d));
        if (files.left)
            scene.pair = {readers::read_image(folder / files.left),
                          readers::read_image(folder / files.right)};
        scenes.push_back(std::move(scene));
    }
    return scenes;
}

}  // namespace hexrelief::checks::mistakes
