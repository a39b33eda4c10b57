#include "tests/mesher/densities.h"

#include <cmath>
#include <random>

namespace hexrelief::testing_mesher {
namespace {

template <typename Value>
DensityMap make_density(int width, int height, const Value& value) {
    DensityMap density;
    density.width = width;
    density.height = height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) density.values.push_back(static_cast<float>(value(x, y)));
    return density;
}

}  // namespace

DensityMap flat_density(int width, int height, float value) {
    return make_density(width, height, [&](int, int) { return value; });
}

DensityMap ramp_density(int width, int height) {
    return make_density(width, height, [&](int x, int) { return std::pow((x + 0.5) / width, 3); });
}

DensityMap bumps_density(int width, int height) {
    return make_density(width, height, [&](int x, int y) {
        const double u = (x + 0.5) / width, v = (y + 0.5) / height;
        if (u > 0.7 && v > 0.75) return 0.0;
        if (std::hypot(u - 0.3, v - 0.4) < 0.18) return 1.0;
        if (std::hypot(u - 0.75, v - 0.3) < 0.12) return 0.5;
        return 0.04;
    });
}

DensityMap leaves_density(int width, int height, bool hanging) {
    DensityMap density = flat_density(width, height, 0);
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const double x = 300.0 * column / width, y = 240.0 * (hanging ? height - 1 - row : row) / height;
            const auto leaf = [&](double foot, double lean, double tip) {
                return y >= tip && std::abs(x - foot - lean * (160 - y)) < 10 + 0.1 * (y - tip);
            };
            float& d = density.values[static_cast<std::size_t>(row) * width + column];
            if (y >= 160) d = 0.8f;
            if (leaf(60, -0.25, 20) || leaf(150, 0.1, 0) || leaf(220, 0.4, 35)) d = 1;
        }
    return density;
}

DensityMap two_discs_density(int width, int height) {
    DensityMap density = flat_density(width, height, 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (std::min(std::hypot(x - 0.2 * width, y - 0.2 * height),
                         std::hypot(x - 0.8 * width, y - 0.8 * height)) < 0.15 * height)
                density.values[static_cast<std::size_t>(y) * width + x] = 1;
    return density;
}

DensityMap noise_density(int width, int height, std::uint32_t seed) {
    std::mt19937 random(seed);
    return make_density(width, height, [&](int, int) {
        const double share = static_cast<double>(random() >> 8) / (1 << 24);
        return random() % 4 == 0 ? 0.0 : share * share * share;
    });
}

DensityMap bright_pixel_density(int width, int height, int x, int y) {
    return make_density(width, height, [&](int u, int v) { return u == x && v == y ? 0.7 : 0.0; });
}

HexMesh2D solve(const DensityMap& density, const MeshConfig& config, int threads) {
    return mesher::solve_mesh(density, config, threads, {});
}

std::string describe(const DensityMap& density, const MeshConfig& config) {
    return std::to_string(density.width) + "x" + std::to_string(density.height) + " px, spacing " +
           std::to_string(config.spacing_px) + ", levels " + std::to_string(config.levels) + ", t_max " +
           std::to_string(config.t_max) + ", sigma " + std::to_string(config.sigma_init) + ", co " +
           std::to_string(config.co) + ", delta " + std::to_string(config.delta) + ", ssr " +
           std::to_string(config.ssr) + ", seed " + std::to_string(config.seed);
}

}  // namespace hexrelief::testing_mesher
