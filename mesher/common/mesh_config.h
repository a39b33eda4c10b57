// Parameters of the mesh stage, by the paper's names (Table 1 and section 4). The field table of
// pipeline/config has their ranges.
#pragma once

#include <cstdint>

namespace hexrelief {

enum class MeshMethod { cellular, sequential };
enum class MeshBorder {
    // As slide, but on the border of the smallest rectangle around all density. With balancing, its upper and
    // lower
    // side bend into empty valleys (mesher/som/mesh_area.h).
    fit,
    slide,  // the lattice's border stays on the image's border, sliding along it: the whole image is meshed
    free,   // the paper's: the border's neurons move like all others, so the mesh draws in from the image's
            // border
};

// After each level's training: equal honeycomb weights (Eq. 1 and 2) with well-shaped triangles
// (mesher/balance/balance.h).
struct BalanceConfig {
    bool enabled = true;
    // Iterations planned for the finest level and the next coarser; twice as many for all others. A level
    // that is far from balance takes up to eight times as many; one that is near balance, or comes no nearer,
    // ends earlier.
    int iterations = 20;
    int sweeps = 8;  // of the linear solver in each iteration
    // Balance against shape: 1 % of the triangles may be thinner than this. Smaller = better balanced, larger
    // = better shaped.
    double least_angle_deg = 8.15;
    double floor = 0.005;  // density of empty pixels while balancing, as a share of the others' mean
};

struct MeshConfig {
    double spacing_px = 6;                     // g: lattice of W/g x H/g vertices
    MeshMethod method = MeshMethod::cellular;  // sequential: the paper's CPU counterpart, one level only
    int levels = 0;               // lattice levels, coarse to fine; 1 = the paper's, 0 = chosen from the size
    int t_max = 10;               // parallel iterations of each level; 60 where no balance follows
    double alpha_init = 1;        // learning rate at the first iteration of all
    double alpha_final = 0.01;    // and after the last
    double sigma_init = 6;        // neighbourhood radius (lattice steps) at the first iteration of all
    double sigma_level_init = 4;  // and at the first iteration of each finer level
    double sigma_level_final = 2;  // after the last iteration of each level but the finest
    double sigma_final = 1;        // after the last iteration of all
    int co = 10;                   // side of a cell of the cellular matrix, px
    double delta = 4;              // points the densest cell extracts an iteration (Eq. 6; the paper's 1)
    int ssr = 3;                   // spiral search range in cells; 0 = unlimited, exact with crr 1
    int crr = 10;       // cell refresh rate: iterations between two sortings of the neurons into cells
    int prr = 5;        // position refresh rate: iterations that seek their best matching units on the same
                        // positions, at the first iteration of all
    int prr_final = 0;  // and at the last; 0 = the same
    double magnification = 1.1;  // points are drawn from density^magnification; 1 = the paper's; 1.3 is best
                                 // where no balance follows
    MeshBorder border = MeshBorder::fit;
    std::uint64_t seed = 1;
    BalanceConfig balance;
};

}  // namespace hexrelief
