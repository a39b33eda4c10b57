// One texture for a surface that is made of several views.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/data/crop.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/image.h"

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

// A view's picture at any size, and the map whose known pixels say what is used of it.
struct PictureInUse {
    const Image& picture;
    const DisparityMap& used;
};

// Returns the atlas. Blocks of the pictures without a used pixel in them or beside them are black, which
// takes hardly any bytes. The atlas has the left picture's channels.
TextureAtlas make_atlas(const Image& left, const std::vector<PictureInUse>& others);

}  // namespace hexrelief::stages
