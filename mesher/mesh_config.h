// Parameters of the mesh stage, by the paper's names (Table 1 and section 4).
#pragma once

#include <cstdint>

namespace hexrelief {

enum class MeshMethod { cellular, sequential };

struct MeshConfig {
    double spacing_px = 6;        // g: lattice of W/g x H/g vertices; 2..256
    MeshMethod method = MeshMethod::cellular;
    int levels = 0;               // lattice levels, coarse to fine; 1 = the paper's single level, 0 = chosen from the size
    int t_max = 300;              // parallel iterations, all levels together
    double alpha_init = 1;        // learning rate at the first iteration, 0..1
    double alpha_final = 0.01;    // and after the last
    double sigma_init = 12;       // neighbourhood radius (lattice steps) at the first iteration
    double sigma_final = 1;       // and after the last
    int co = 20;                  // side of a cell of the cellular matrix, px
    double delta = 1;             // degree of cell activity (Eq. 6)
    int ssr = 3;                  // spiral search range in cells; 0 = unlimited, then exact
    int crr = 20;                 // cell refresh rate: iterations between two sortings of the neurons into cells
    std::uint64_t seed = 1;
};

}  // namespace hexrelief
