// Shared parts of the tests of the CUDA backend: one context, and the comparison with the CPU.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>

#include "cuda/cuda_mesher.h"
#include "tests/mesher/densities.h"

namespace hexrelief::testing_cuda {

using testing_mesher::paper_config;

// Returns the shared context, or null if no device is usable.
inline cuda::CudaMesher* shared_mesher() {
    static const std::unique_ptr<cuda::CudaMesher> mesher =
        cuda::list_cuda_devices(nullptr).empty() ? nullptr : std::make_unique<cuda::CudaMesher>();
    return mesher.get();
}

#define HEXRELIEF_NEEDS_DEVICE() \
    if (!shared_mesher()) GTEST_SKIP() << "no CUDA device here: CPU and CUDA were not compared"

inline bool same_bytes(const HexMesh2D& a, const HexMesh2D& b) {
    return a.columns == b.columns && a.rows == b.rows && a.iterations == b.iterations &&
           a.positions.size() == b.positions.size() &&
           std::memcmp(a.positions.data(), b.positions.data(), a.positions.size() * sizeof(Vec2f)) == 0;
}

// Returns disparities that follow the density, unknown where it is 0.
inline DisparityMap varied_map(const DensityMap& density) {
    DisparityMap map{density.width, density.height, density.values};
    for (float& d : map.values) d = d > 0 ? 10 + 30 * d : kUnknownDisparity;
    return map;
}

inline MeshConfig quick_config(int t_max) {
    return {.t_max = t_max, .balance = {.enabled = false}};
}

inline MeshConfig balanced_config(int iterations) {
    return {.t_max = 5, .balance = {.iterations = iterations}};
}

// Solves on both backends and compares the results; asserts that the device did the work.
inline void expect_equal(const DensityMap& density, const MeshConfig& config) {
    const HexMesh2D cpu = mesher::solve_mesh(density, config, 2, {});
    const HexMesh2D cuda = shared_mesher()->solve(density, config, {});
    EXPECT_GT(shared_mesher()->figures().bytes, 0u) << "the device did nothing";
    EXPECT_EQ(shared_mesher()->figures().balance_s > 0, config.balance.enabled);
    EXPECT_TRUE(same_bytes(cpu, cuda)) << testing_mesher::describe(density, config);
}

}  // namespace hexrelief::testing_cuda
