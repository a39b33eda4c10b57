// One texture for a surface that is made of several views.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

// What a sheet shows of a picture by its texture coordinates.
struct UsedPart {
    std::vector<char> pixels;  // 1 or 0, row-major
    // Of the picture's blocks of kAtlasBlock_px, row-major: equal numbers for blocks that stay beside each
    // other in an atlas, because triangles span them; kNoChart = nothing there is used.
    std::vector<std::uint32_t> charts;
};
inline constexpr int kAtlasBlock_px = 16;  // whole blocks of a JPEG file, and of a WebP file's halved colours
inline constexpr std::uint32_t kNoChart = ~std::uint32_t{0};

// stays_whole: all blocks make one chart,
// for coarser sheets that will show other parts as well.
UsedPart used_part(const Image& picture, const SurfaceMesh& sheet, bool stays_whole, int threads);

// A view's picture at any size, and what is used of it.
struct PictureInUse {
    const Image& picture;
    UsedPart used;
};

// The left picture, and what is used of the other views' pictures below it.
struct TextureAtlas {
    // Where a picture of `width` x `height` px lies: what is at (x, y) of it is at (x, y) + the shift of its
    // block, px.
    struct Place {
        int width = 0, height = 0;
        std::vector<std::array<int, 2>> shifts;
    };
    Image picture;
    std::vector<Place> places;  // the left picture's, and those of the others in their order

    // Moves texture coordinates of one view's picture into the atlas.
    void move_in(std::span<Vec2f> texcoords, std::size_t view) const;
};

// Returns the atlas. What is not used, or beside what is, has smooth colours, which take hardly any bytes and
// do not show where textures are interpolated. The atlas has the left picture's channels, and its memory if
// that has room below it.
TextureAtlas make_atlas(Image left, const std::vector<PictureInUse>& others, int threads);
// Returns a copy of the left picture with such room.
Image with_room_below(const Image& left);

}  // namespace hexrelief::stages
