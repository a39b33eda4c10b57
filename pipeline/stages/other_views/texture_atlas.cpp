#include "pipeline/stages/other_views/texture_atlas.h"

#include <algorithm>
#include <cstddef>

namespace hexrelief::stages {
namespace {

constexpr int kBlock_px = 8;      // of a JPEG file
constexpr double kBeside_px = 1;  // what is so near a used pixel is used, too
constexpr int kWhole_px = 16;     // of a WebP file, whose colours are halved

// The blocks of a picture that are used, row-major.
struct Blocks {
    int columns, rows;
    std::vector<char> is_used;

    bool at(int column, int row) const { return is_used[static_cast<std::size_t>(row) * columns + column]; }
    // Uses what lies in a row of the picture from x on, to last_x.
    void use(double x, double last_x, double y) {
        const auto block = [](double at, int blocks) {
            return std::clamp(static_cast<int>(at / kBlock_px), 0, blocks - 1);
        };
        for (int r = block(y - kBeside_px, rows); r <= block(y + kBeside_px, rows); ++r)
            for (int c = block(x - kBeside_px, columns); c <= block(last_x + kBeside_px, columns); ++c)
                is_used[static_cast<std::size_t>(r) * columns + c] = 1;
    }
};

Blocks used_blocks(const PictureInUse& view) {
    const auto& [picture, used] = view;
    Blocks blocks{
        (picture.width + kBlock_px - 1) / kBlock_px, (picture.height + kBlock_px - 1) / kBlock_px, {}};
    blocks.is_used.resize(static_cast<std::size_t>(blocks.columns) * blocks.rows);
    const auto middle = [&](int x) { return (x + 0.5) * picture.width / used.width; };
    for (int y = 0; y < used.height; ++y)
        for (int x = 0; x < used.width; ++x) {
            const int first = x;
            while (x < used.width && DisparityMap::known(used.at(x, y))) ++x;
            if (x > first) blocks.use(middle(first), middle(x - 1), (y + 0.5) * picture.height / used.height);
        }
    return blocks;
}

// Returns the smallest part of the picture with all used blocks; without pixels if there are none.
PixelRect part_of(const Blocks& blocks, const Image& picture) {
    int left = blocks.columns, right = 0, top = blocks.rows, bottom = 0;
    for (int row = 0; row < blocks.rows; ++row)
        for (int column = 0; column < blocks.columns; ++column)
            if (blocks.is_used[static_cast<std::size_t>(row) * blocks.columns + column]) {
                left = std::min(left, column);
                right = std::max(right, column + 1);
                top = std::min(top, row);
                bottom = std::max(bottom, row + 1);
            }
    if (bottom == 0) return {};
    const int x = left * kBlock_px / kWhole_px * kWhole_px, y = top * kBlock_px / kWhole_px * kWhole_px;
    return {x, y, std::min(picture.width, right * kBlock_px) - x,
            std::min(picture.height, bottom * kBlock_px) - y};
}

int whole_blocks(int px) {
    return (px + kWhole_px - 1) / kWhole_px * kWhole_px;
}

void copy_pixel(const std::uint8_t* from, int from_channels, std::uint8_t* to, int to_channels) {
    if (from_channels == 1)
        std::fill_n(to, to_channels, from[0]);
    else
        to[0] = static_cast<std::uint8_t>((from[0] + 2 * from[1] + from[2]) / 4);
}

// Copies the used blocks. The part begins with whole blocks.
void copy_used(const Image& from, const Blocks& blocks, const PixelRect& part, Image& to, int to_x,
               int to_y) {
    for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; x += kBlock_px) {
            if (!blocks.at((part.x + x) / kBlock_px, (part.y + y) / kBlock_px)) continue;
            const int count = std::min(kBlock_px, part.width - x);
            const std::uint8_t* source = from.at(part.x + x, part.y + y);
            std::uint8_t* target = to.at(to_x + x, to_y + y);
            if (from.channels == to.channels) {
                std::copy_n(source, count * to.channels, target);
                continue;
            }
            for (int i = 0; i < count; ++i, source += from.channels, target += to.channels)
                copy_pixel(source, from.channels, target, to.channels);
        }
}

}  // namespace

void TextureAtlas::move_in(std::span<Vec2f> texcoords, std::size_t view) const {
    const Place& place = places[view];
    for (Vec2f& t : texcoords)
        t = {static_cast<float>((t.x * place.width + place.x) / picture.width),
             static_cast<float>((t.y * place.height + place.y) / picture.height)};
}

TextureAtlas make_atlas(const Image& left, const std::vector<PictureInUse>& others) {
    std::vector<Blocks> blocks;
    std::vector<PixelRect> parts, placed;
    // The parts lie in shelves below the left picture, as many beside each other as fit.
    int x = 0, y = whole_blocks(left.height), shelf = 0;
    for (const PictureInUse& view : others) {
        blocks.push_back(used_blocks(view));
        const PixelRect part = part_of(blocks.back(), view.picture);
        if (x + part.width > left.width) {
            y += shelf;
            x = shelf = 0;
        }
        parts.push_back(part);
        placed.push_back({x, y, part.width, part.height});
        x += whole_blocks(part.width);
        shelf = std::max(shelf, whole_blocks(part.height));
    }
    TextureAtlas atlas{{left.width, y + shelf, left.channels, {}}, {}};
    Image& picture = atlas.picture;
    const std::size_t bytes = static_cast<std::size_t>(picture.width) * picture.height * picture.channels;
    picture.pixels.reserve(bytes);
    picture.pixels = left.pixels;
    picture.pixels.resize(bytes);
    atlas.places.push_back({0, 0, static_cast<double>(left.width), static_cast<double>(left.height)});
    for (std::size_t i = 0; i < others.size(); ++i) {
        const Image& other = others[i].picture;
        copy_used(other, blocks[i], parts[i], picture, placed[i].x, placed[i].y);
        atlas.places.push_back({static_cast<double>(placed[i].x - parts[i].x),
                                static_cast<double>(placed[i].y - parts[i].y),
                                static_cast<double>(other.width), static_cast<double>(other.height)});
    }
    return atlas;
}

}  // namespace hexrelief::stages
