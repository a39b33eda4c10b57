// bench_matching [RUNS [WIDTH HEIGHT DISPARITIES | LEFT.ppm RIGHT.ppm DISPARITIES]]: measures match_pair() on
// the device, with transfers (the median, in ms), and prints the time of writing and reading the sums of path
// costs once at 4.8 TB/s for comparison. Nsight Systems shows the single kernels. Checks at the smallest size
// that the bytes equal the CPU's.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/cuda_matcher.h"
#include "tests/cuda/made_up_pairs.h"

namespace hexrelief::testing_cuda {
namespace {

struct Size {
    int width, height, disparities;
};
constexpr Size kSizes[] = {
    {450, 375, 64}, {1024, 440, 128}, {1282, 1110, 224}, {1800, 1500, 256}, {8192, 8192, 1024}};

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

StereoPair large_pair(const Size& size) {
    const int tile = std::min(size.width, 2048);
    const PairSpec spec{
        tile, std::min(size.height, 2048), 3, 3, size.disparities * 3 / 4, size.disparities / 10, 99};
    const StereoPair part = made_up_pair(spec);
    StereoPair pair{{size.width, size.height, 3, {}}, {size.width, size.height, 3, {}}};
    for (const auto& [from, to] : {std::pair{&part.left, &pair.left}, std::pair{&part.right, &pair.right}})
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; x += tile)
                to->pixels.insert(to->pixels.end(), from->at(0, y % from->height),
                                  from->at(0, y % from->height) + 3 * std::min(tile, size.width - x));
    return pair;
}

// Reads a binary colour file without a comment in its header, as ImageMagick writes it.
Image read_ppm(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string magic;
    int width = 0, height = 0, most = 0;
    file >> magic >> width >> height >> most;
    file.ignore();
    Image image{width, height, 3, {std::istreambuf_iterator<char>(file), {}}};
    if (magic != "P6" || most != 255 || image.pixels.size() != std::size_t{3} * width * height)
        throw std::runtime_error(path + ": no P6 image of 8 bits");
    return image;
}

bool measure(cuda::CudaMatcher& matcher, const Size& size, int runs, const StereoPair& pair) {
    matching::MatchingConfig config;
    config.range = {0, size.disparities};
    matching::MatchedMap map = matcher.match_pair(pair, config);
    std::vector<double> whole;
    for (int i = 0; i < runs; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        map = matcher.match_pair(pair, config);
        whole.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    }
    const double entries = static_cast<double>(size.width) * size.height * size.disparities;
    const double floor_ms = entries * 2 * sizeof(std::uint16_t) / 4.8e12 * 1e3;
    std::printf("%5dx%d x%d: %.3f ms, floor %.3f ms, ratio %.2f, device %zu MiB\n", size.width, size.height,
                size.disparities, median(whole), floor_ms, median(whole) / floor_ms,
                matcher.device_bytes() >> 20);
    std::fflush(stdout);
    if (size.width > 450) return true;
    const matching::MatchedMap cpu = matching::match_pair(pair, config, 4);
    const bool same = cpu.disparities == map.disparities && cpu.is_matched == map.is_matched;
    std::printf("    the CPU's bytes: %s\n", same ? "equal" : "DIFFERENT");
    return same;
}

}  // namespace
}  // namespace hexrelief::testing_cuda

int main(int argc, char** argv) {
    using namespace hexrelief::testing_cuda;
    const int runs = argc > 1 ? std::atoi(argv[1]) : 20;
    try {
        hexrelief::cuda::CudaMatcher matcher;
        bool same = true;
        if (argc > 4) {
            const Size size{std::atoi(argv[2]), std::atoi(argv[3]), std::atoi(argv[4])};
            const bool made_up = size.width > 0;
            const hexrelief::StereoPair pair =
                made_up ? large_pair(size) : hexrelief::StereoPair{read_ppm(argv[2]), read_ppm(argv[3])};
            return measure(matcher, {pair.left.width, pair.left.height, size.disparities}, runs, pair) ? 0
                                                                                                       : 1;
        }
        for (const Size& size : kSizes)
            same &= measure(matcher, size, size.width > 4000 ? 2 : runs, large_pair(size));
        return same ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_matching: %s\n", error.what());
        return 5;
    }
}
