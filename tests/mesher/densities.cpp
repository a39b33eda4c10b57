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

DisparityMap flat_map(const DensityMap& density) {
    return {density.width, density.height, std::vector<float>(density.values.size(), 10.0f)};
}

HexMesh2D solve(const DensityMap& density, const MeshConfig& config, int threads) {
    return solve_mesh_cpu(density, flat_map(density), config, threads, {}).mesh;
}

std::string describe(const DensityMap& density, const MeshConfig& config) {
    return std::to_string(density.width) + "x" + std::to_string(density.height) + " px, spacing " +
           std::to_string(config.spacing_px) + ", levels " + std::to_string(config.levels) + ", t_max " +
           std::to_string(config.t_max) + ", sigma " + std::to_string(config.sigma_init) + ", co " +
           std::to_string(config.co) + ", delta " + std::to_string(config.delta) + ", ssr " +
           std::to_string(config.ssr) + ", seed " + std::to_string(config.seed);
}

}  // namespace hexrelief::testing_mesher
