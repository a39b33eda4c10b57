// One texture for a surface that is made of several views.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/data/crop.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

// The left picture, and what is used of the other views' pictures below it.
struct TextureAtlas {
    // A picture of `width` x `height` px, whose first pixel would be at (x, y) of the atlas.
    struct Place {
        double x = 0, y = 0, width = 0, height = 0;
    };
    Image picture;
    std::vector<Place> places;  // the left picture's, and those of the others in their order

    // Moves texture coordinates of one view's picture into the atlas.
    void move_in(std::span<Vec2f> texcoords, std::size_t view) const;
};

// Returns 1 for each pixel of a view's picture, row-major, that a sheet shows by its texture coordinates, but
// for where it overlaps with the surface that it is added to. here: this surface as the view shows it. The
// same for any number of threads.
std::vector<char> used_pixels(const Image& picture, const SurfaceMesh& sheet, const SeenSurface& here,
                              int threads);

// A view's picture at any size, and what is used of it: 1 or 0 per pixel, row-major.
struct PictureInUse {
    const Image& picture;
    std::vector<char> used;
};

// Returns the atlas. What is not used, or beside what is, has smooth colours, which take hardly any bytes and
// do not show where textures are interpolated. The atlas has the left picture's channels.
TextureAtlas make_atlas(const Image& left, const std::vector<PictureInUse>& others);

}  // namespace hexrelief::stages
