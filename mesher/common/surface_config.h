// Parameters of the surface stage, which cuts the lattice along silhouettes and fits it to the disparities.
// The field table of pipeline/config has their ranges.
#pragma once

namespace hexrelief {

enum class Discontinuities { cut, bridge };
// The cameras whose views the surface is made of.
enum class SurfaceViews { both, left };

struct SurfaceConfig {
    // cut: no triangle spans a depth discontinuity; bridge: one connected mesh, open only at
    // background and unknown regions.
    Discontinuities discontinuities = Discontinuities::cut;
    // Two neighbouring pixels are a depth discontinuity if their disparities differ by more than this. 0 = 1
    // px, which is the steepest surface that both cameras see.
    double least_discontinuity_px = 0;
    // Number of rounds in which triangles that still straddle two surfaces are split at their boundary and
    // all silhouettes are fitted again.
    int split_rounds = 3;
    // Distance by which the two mesh borders at a high depth discontinuity are inset into their own surfaces.
    // The map determines the exact position only to half a pixel; a border on the discontinuity itself shows
    // the nearer surface up to a part of a pixel too wide to the other camera.
    double silhouette_inset_px = 0;
    // Number of rounds in which border vertices are then moved, by up to 0.75 px, if that lowers the error of
    // the pixels around them; done after the mesher, on the CPU (pipeline/stages/silhouettes.h).
    int silhouette_rounds = 0;
    // Smaller connected components, in triangles, are dropped from the surface in space; 0 = keep all.
    int min_component = 0;
    // Depth of the backdrop that ends a matched pair's scene, as a multiple of the depth that its matches
    // support (pipeline/stages/disparity_range.h); 0 = the scene has no end.
    double farthest = 1.1;
    // both: what only the right camera sees is part of the surface, too (pipeline/stages/other_views).
    SurfaceViews views = SurfaceViews::both;
    // Behind silhouettes, surfaces continue as far as cameras so many baselines beyond both see; 0 = not at
    // all. Only with views = both.
    double behind = 1;
};

}  // namespace hexrelief
