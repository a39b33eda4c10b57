// Gives each target the seeds in its folder, without a fuzzer: what was found stays mended.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/targets.h"

int main(int argc, char** argv) {
    namespace fs = std::filesystem;
    if (argc != 2) return 2;
    for (const hexrelief::fuzz::Target& target : hexrelief::fuzz::targets()) {
        int count = 0;
        std::error_code missing;  // no folder: no seeds
        for (const auto& seed : fs::directory_iterator(fs::path(argv[1]) / target.name, missing)) {
            std::ifstream stream(seed.path(), std::ios::binary);
            const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
            std::printf("%s\n", seed.path().c_str());
            std::fflush(stdout);  // names the seed where it ends the process
            hexrelief::fuzz::run(target, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
            ++count;
        }
        if (count == 0) {
            std::printf("%s has no seeds\n", target.name.c_str());
            return 1;
        }
    }
    return 0;
}
