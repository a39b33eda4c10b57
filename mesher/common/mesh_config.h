// Parameters of the mesh stage, named as in the paper (Table 1 and section 4), and the callback by which a
// long stage reports its progress. The field table in pipeline/config has the parameters' ranges.
#pragma once

#include <cstdint>
#include <functional>

namespace hexrelief {

enum class MeshMethod { cellular, sequential };
enum class MeshBorder {
    // Like slide, but on the border of the smallest rectangle around all density. With balancing, its upper
    // and lower sides bend into empty valleys (mesher/som/level_plan.h).
    fit,
    slide,  // the lattice's border slides along the image's border: the whole image is meshed
    // The paper's: border neurons move like all others, so the mesh shrinks away from the image's border
    free,
};

// Balancing, which follows each level's training: equal honeycomb weights (Eq. 1 and 2)
// with well-shaped triangles (mesher/balance/balance.h).
struct BalanceConfig {
    bool enabled = true;
    // Iterations planned for the finest level and the next coarser; all others get twice as many. A level
    // that is far from balance takes up to eight times as many; one that is close to balance, or no
    // longer improves, ends earlier.
    int iterations = 20;
    int sweeps = 8;  // sweeps of the linear solver in each iteration
    // Trades balance for shape: up to 1 % of the triangles may have a smaller least angle than this. A
    // smaller value gives better balance, a larger one better shapes.
    double least_angle_deg = 8.15;
    // Density that empty pixels get while balancing, as a share of the other pixels' mean.
    double floor = 0.005;
};

struct MeshConfig {
    double spacing_px = 6;                     // g: the lattice has W/g x H/g vertices
    MeshMethod method = MeshMethod::cellular;  // sequential: the paper's CPU counterpart, one level only
    int levels = 0;             // lattice levels, coarse to fine; 1 = the paper's, 0 = chosen from the size
    int t_max = 10;             // parallel iterations of each level; 60 if no balancing follows
    double alpha_init = 1;      // learning rate at the first iteration of the first level
    double alpha_final = 0.01;  // learning rate after the last iteration of the last level
    double sigma_init = 6;  // neighbourhood radius (lattice steps) at the first iteration of the first level
    double sigma_level_init = 4;   // radius at the first iteration of each finer level
    double sigma_level_final = 2;  // radius after the last iteration of each level except the finest
    double sigma_final = 1;        // radius after the last iteration of the finest level
    int co = 10;                   // side of a cell of the cellular matrix, px
    double delta = 4;  // points that the densest cell extracts in an iteration (Eq. 6; the paper's is 1)
    int ssr = 3;       // spiral search range in cells; 0 = unlimited, exact if crr is 1
    int crr = 10;      // cell refresh rate: iterations between two sortings of the neurons into cells
    // Position refresh rate: iterations that search best matching units on the same positions, at the
    // start of the run
    int prr = 5;
    int prr_final = 0;  // prr at the end of the run; 0 = prr throughout
    // Points are drawn from density^magnification; 1 = the paper's; 1.3 is best if no balancing follows
    double magnification = 1.1;
    MeshBorder border = MeshBorder::fit;
    std::uint64_t seed = 1;
    BalanceConfig balance = {};
};

// Reports the progress of a long stage: called now and then with the share done, 0..1; may throw to stop the
// stage.
using ProgressFunction = std::function<void(double)>;

}  // namespace hexrelief
