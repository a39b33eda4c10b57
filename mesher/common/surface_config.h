// How the lattice is opened along silhouettes and laid onto the disparities.
#pragma once

namespace hexrelief {

enum class Discontinuities { cut, bridge };

struct SheetConfig {
    // cut: no triangle spans a depth jump; bridge: one sheet, open only at background and unknown regions.
    Discontinuities discontinuities = Discontinuities::cut;
    // Neighbouring pixels' disparities that differ by more are a depth jump. 0 = chosen: 1 px, the steepest
    // surface that both cameras see, and half the map's quantisation step.
    double max_disparity_jump_px = 0;
    // How far a clear edge of the colour image may move a rim from the pixel sides that the map puts it on.
    // It helps on matched maps; on maps that are exact to the pixel it does harm.
    double color_shift_px = 0.25;  // 0..0.5; 0 = colours are not looked at
    // How often triangles that still lie on two surfaces are split where these meet, and all rims fitted
    // anew.
    int split_rounds = 3;  // 1..8
    // How far inside of its own surface each of the two rims at a high depth jump ends. The map leaves half a
    // pixel open; a rim on the silhouette shows the other camera the near surface where that one should be
    // gone for part of a pixel.
    double rim_inset_px = 0;  // 0..0.5
};

}  // namespace hexrelief
