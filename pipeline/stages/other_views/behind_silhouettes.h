// Continues surfaces behind the silhouettes that hide them.
#pragma once

#include "pipeline/stages/other_views/continued.h"
#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::stages {

// How far beside a view, in baselines, cameras stand that look behind its silhouettes, and how wide these
// are.
struct Beyond {
    static constexpr int kMixed_px = 3;
    // In photographs the nearer surface turns away, or is out of focus.
    static constexpr int kMixedOfPhotographs_px = 12;

    double left = 0, right = 0, up = 0, down = 0;
    // Pixels beside a silhouette whose colours, from 4 on also disparities, may be mixed of both surfaces.
    int mixed_px = kMixed_px;
};

// What continues in a view, and what the view shows in front of it.
struct Behind {
    Continued continued;
    Disparities front;
};

// Adds to `missing` what the view's silhouettes hide from itself, and the cameras beyond see: the farther one
// of the two surfaces at a silhouette continues behind the nearer one along its slope, as far as the
// outermost of these cameras sees. It stays behind `visible`, and is no more than a sixteenth of the view
// long.
// here: the surface as the view shows it. Nothing continues behind a border of the surface that has nothing
// behind it. Returns what paint_behind() needs. The same for any number of threads.
Behind continue_behind(OtherView& view, const SeenSurface& here, const Beyond& beyond,
                       const VisibleSurface& visible, int threads);

// Makes the view's texture show what continues in place of what hides it: with the farther surface's texture,
// or where that is not found in its mirrored colours. backing: the view's, or none; gets a picture, the
// view's at half its size with the backing's texture. Leaves `missing` as it is. The same for any number of
// threads.
void paint_behind(OtherView& view, Behind hidden, OtherView* backing, int threads);

// Adds to `missing` a border of the surface around it, of border_px >= 1 px, so that the parts overlap with
// the surface and with each other; gives regions of fewer than `least` pixels to those around them, and
// drops parts that nobody would miss. The same for any number of threads.
void join_to_surface(OtherView& view, const SeenSurface& here, int border_px, std::size_t least, int threads);

}  // namespace hexrelief::stages
