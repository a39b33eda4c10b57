// Parameters of the mesh stage, by the paper's names (Table 1 and section 4).
#pragma once

#include <cstdint>

namespace hexrelief {

enum class MeshMethod { cellular, sequential };
enum class MeshBorder {
    slide,  // the lattice's border stays on the image's border, sliding along it: the whole image is meshed
    free,   // the paper's: neurons of the border move like all others, and the mesh draws in from the image's
            // border
};

struct MeshConfig {
    double spacing_px = 6;                     // g: lattice of W/g x H/g vertices; 2..256
    MeshMethod method = MeshMethod::cellular;  // sequential: the paper's CPU counterpart, one level only
    int levels = 0;               // lattice levels, coarse to fine; 1 = the paper's, 0 = chosen from the size
    int t_max = 60;               // parallel iterations of each level
    double alpha_init = 1;        // learning rate at the first iteration of all, 0..1
    double alpha_final = 0.01;    // and after the last
    double sigma_init = 6;        // neighbourhood radius (lattice steps) at the first iteration of all
    double sigma_level_init = 4;  // and at the first iteration of each finer level
    double sigma_level_final = 2;  // after the last iteration of each level but the finest
    double sigma_final = 1;        // after the last iteration of all
    int co = 10;                   // side of a cell of the cellular matrix, px
    double delta = 4;              // points the densest cell extracts an iteration (Eq. 6; the paper's 1)
    int ssr = 3;                   // spiral search range in cells; 0 = unlimited, exact with crr 1
    int crr = 10;  // cell refresh rate: iterations between two sortings of the neurons into cells
    double magnification = 1.3;  // points are drawn from density^magnification; 1 = the paper's
    MeshBorder border = MeshBorder::slide;
    std::uint64_t seed = 1;
};

}  // namespace hexrelief
