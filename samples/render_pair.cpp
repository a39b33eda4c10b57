// render_pair [--photographs] FOLDER: writes left.png, right.png, disparity.pfm and calib.txt of the
// synthetic sample scene, or left.png and right.png as if photographed by hand.
#include <cstdio>
#include <exception>
#include <string>

#include "samples/sample_pair.h"

int main(int argc, char** argv) {
    const bool photographs = argc == 3 && std::string(argv[1]) == "--photographs";
    if (argc != 2 && !photographs) {
        std::fprintf(stderr, "usage: render_pair [--photographs] FOLDER\n");
        return 2;
    }
    try {
        using namespace hexrelief::samples;
        write_sample_files(photographs ? photograph_files() : sample_files(), argv[argc - 1]);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "render_pair: %s\n", error.what());
        return 4;
    }
}
