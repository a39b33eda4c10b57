// render_pair FOLDER: writes left.png, right.png, disparity.pfm and calib.txt of the synthetic sample scene.
#include <cstdio>
#include <exception>

#include "samples/scene_files.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: render_pair FOLDER\n");
        return 2;
    }
    try {
        hexrelief::samples::write_sample_files(hexrelief::samples::sample_files(), argv[1]);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "render_pair: %s\n", error.what());
        return 4;
    }
}
