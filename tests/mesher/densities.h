// Small densities of every kind, and helpers for running the mesher.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include "mesher/mesher.h"
#include "tests/mesher/regular_lattice.h"

namespace hexrelief::testing_mesher {

struct NamedDensity {
    std::string name;
    DensityMap density;

    friend void PrintTo(const NamedDensity& d, std::ostream* out) { *out << d.name; }
};

DensityMap flat_density(int width, int height, float value = 1.0f);
DensityMap ramp_density(int width, int height);  // rises with x
DensityMap bumps_density(int width,
                         int height);  // two discs of different height on a low floor, and a dark corner
// Three leaves that lean on a table, with deep empty valleys between them; upside down if `hanging`.
DensityMap leaves_density(int width, int height, bool hanging);
DensityMap two_discs_density(int width, int height);  // in opposite corners, nothing else
DensityMap noise_density(int width, int height, std::uint32_t seed);
DensityMap bright_pixel_density(int width, int height, int x, int y);

// Returns the paper's schedule: one level, free borders, and no balancing.
inline MeshConfig paper_config(int t_max) {
    return {.levels = 1,
            .t_max = t_max,
            .sigma_init = 12,
            .co = 20,
            .delta = 1,
            .magnification = 1,
            .border = MeshBorder::free,
            .balance = {.enabled = false}};
}

HexMesh2D solve(const DensityMap& density, const MeshConfig& config, int threads = 1);

// Describes a failing configuration: "60x48 columns x rows 10x8 seed 3".
std::string describe(const DensityMap& density, const MeshConfig& config);

}  // namespace hexrelief::testing_mesher
