// Parameters of the surface stage: how the lattice is cut along silhouettes and laid onto the disparities.
// The field table of pipeline/config has their ranges.
#pragma once

namespace hexrelief {

enum class Discontinuities { cut, bridge };

struct SurfaceConfig {
    // cut: no triangle spans a depth discontinuity; bridge: one mesh, open only at background and unknown
    // regions.
    Discontinuities discontinuities = Discontinuities::cut;
    // Neighbouring pixels' disparities that differ by more are a depth discontinuity. 0 = 1 px, the
    // steepest surface that both cameras see.
    double least_discontinuity_px = 0;
    // How far a clear edge of the colour image may move a silhouette from the pixel sides on which the map
    // puts it. On matched maps it changes next to nothing, on maps that are exact to the pixel it does harm.
    double color_shift_px = 0;  // 0 = colours are not used
    // How often triangles that still lie on two surfaces are split where these meet, and all silhouettes
    // fitted anew.
    int split_rounds = 3;
    // How far inside its own surface each of the two mesh borders at a high depth discontinuity ends. The map
    // leaves the exact position open by half a pixel; a border on the discontinuity itself shows the other
    // camera the nearer surface up to a part of a pixel too far.
    double silhouette_inset_px = 0;
    // How often border vertices are then moved, by up to 0.75 px, where that lowers the error of the pixels
    // around them; after the mesher, on the CPU (pipeline/stages/silhouettes.h).
    int silhouette_rounds = 0;
    // Connected components of fewer triangles are dropped from the surface in space; 0 = keep all.
    int min_component = 0;
};

}  // namespace hexrelief
