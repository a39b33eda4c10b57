#include "pipeline/stages/other_views/texture_atlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {
namespace {

constexpr int kBlock_px = 8;   // of a JPEG file
constexpr int kWhole_px = 16;  // of a JPEG or WebP file whose colours are halved
constexpr int kBeside_px = 1;  // what is so near a used pixel is used, too: it is interpolated with it
constexpr int kSmoothingRounds = 8;

int whole_blocks(int px) {
    return (px + kWhole_px - 1) / kWhole_px * kWhole_px;
}

// Calls take(first, end, y) for the used pixels of each row and what lies beside them; some come several
// times.
template <typename Take>
void for_used_runs(const PictureInUse& view, const Take& take) {
    const int width = view.picture.width, height = view.picture.height;
    for (int y = 0; y < height; ++y) {
        const auto row = view.used.begin() + static_cast<std::ptrdiff_t>(y) * width, row_end = row + width;
        for (auto begin = std::find(row, row_end, 1); begin != row_end;) {
            const auto end = std::find(begin, row_end, 0);
            const int first = std::max(0, static_cast<int>(begin - row) - kBeside_px),
                      last = std::min(width, static_cast<int>(end - row) + kBeside_px);
            for (int v = std::max(0, y - kBeside_px); v <= std::min(height - 1, y + kBeside_px); ++v)
                take(first, last, v);
            begin = std::find(end, row_end, 1);
        }
    }
}

// Returns the smallest part of the picture with all that is used, which begins with a whole block; without
// pixels if nothing is.
PixelRect part_of(const PictureInUse& view) {
    const int width = view.picture.width, height = view.picture.height;
    int left = width, right = 0, top = height, bottom = 0;
    for_used_runs(view, [&](int first, int end, int y) {
        left = std::min(left, first);
        right = std::max(right, end);
        top = std::min(top, y);
        bottom = std::max(bottom, y + 1);
    });
    if (bottom == 0) return {};
    left -= left % kWhole_px;
    top -= top % kWhole_px;
    return {left, top, right - left, bottom - top};
}

void copy_pixel(const std::uint8_t* from, int from_channels, std::uint8_t* to, int to_channels) {
    if (from_channels == to_channels)
        std::copy_n(from, to_channels, to);
    else if (from_channels == 1)
        std::fill_n(to, to_channels, from[0]);
    else
        to[0] = static_cast<std::uint8_t>((from[0] + 2 * from[1] + from[2]) / 4);
}

using Colour = std::array<float, 3>;

// Gives the pixels of a block that have no colour those that a JPEG file needs fewest bytes for: what goes on
// smoothly from the block's others, or if it has none the mean of the block before. Returns the block's mean.
Colour fill_block(Image& atlas, const std::vector<char>& is_known, int x, int y, const Colour& before) {
    const int width = std::min(kBlock_px, atlas.width - x), height = std::min(kBlock_px, atlas.height - y);
    std::array<Colour, kBlock_px * kBlock_px> colours;
    std::array<char, kBlock_px*kBlock_px> has_colour = {}, is_given;
    const auto for_pixels = [&](const auto& visit) {
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u) visit(u, v, v * kBlock_px + u);
    };
    bool is_empty = true, is_full = true;
    for_pixels([&](int u, int v, int i) {
        has_colour[i] = is_known[static_cast<std::size_t>(y + v) * atlas.width + x + u];
        is_empty &= !has_colour[i];
        is_full &= has_colour[i] != 0;
        colours[i] = before;
        if (has_colour[i]) std::copy_n(atlas.at(x + u, y + v), atlas.channels, colours[i].begin());
    });
    is_given = has_colour;
    const auto interpolate = [&](int u, int v, int i) {
        if (is_given[i]) return;
        Colour sum = {};
        int count = 0;
        const auto add = [&](bool is_inside, int other) {
            if (!is_inside || !has_colour[other]) return;
            for (int c = 0; c < atlas.channels; ++c) sum[c] += colours[other][c];
            ++count;
        };
        add(u > 0, i - 1);
        add(u + 1 < width, i + 1);
        add(v > 0, i - kBlock_px);
        add(v + 1 < height, i + kBlock_px);
        if (count == 0) return;
        for (int c = 0; c < atlas.channels; ++c) colours[i][c] = sum[c] / static_cast<float>(count);
        has_colour[i] = 1;
    };
    // Colours cross the block at the latest after so many rounds as it has pixels along two sides.
    const int rounds = is_empty || is_full ? 0 : 2 * kBlock_px + kSmoothingRounds;
    for (int round = 0; round < rounds; ++round) for_pixels(interpolate);
    Colour mean = {};
    for_pixels([&](int u, int v, int i) {
        for (int c = 0; c < atlas.channels; ++c) {
            mean[c] += colours[i][c] / static_cast<float>(width * height);
            if (!is_given[i]) atlas.at(x + u, y + v)[c] = static_cast<std::uint8_t>(colours[i][c] + 0.5f);
        }
    });
    return mean;
}

}  // namespace

std::vector<char> used_pixels(const Image& picture, const SurfaceMesh& sheet, const SeenSurface& here,
                              int threads) {
    View view{{}, &sheet.triangles, picture.width, picture.height};
    for (const Vec2f& t : sheet.texcoords)
        view.points.push_back(
            {static_cast<double>(t.x) * picture.width, static_cast<double>(t.y) * picture.height, 0});
    std::vector<char> used = rasterise_coverage(view, threads);
    const ViewPlace& place = here.place;
    const SeenSurface shown = see(sheet, place, threads);
    const auto pixel_at = [](int at, int size, int other_size) {
        return static_cast<std::size_t>((2 * static_cast<std::int64_t>(at) + 1) * other_size / (2 * size));
    };
    for_row_bands(picture.height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < picture.width; ++x) {
                const std::size_t there = pixel_at(y, picture.height, place.height) * place.width +
                                          pixel_at(x, picture.width, place.width);
                if (here.disparities[there] != kNotCovered &&
                    std::abs(here.disparities[there] - shown.disparities[there]) <= kOneSurface_px)
                    used[static_cast<std::size_t>(y) * picture.width + x] = 0;
            }
    });
    return used;
}

void TextureAtlas::move_in(std::span<Vec2f> texcoords, std::size_t view) const {
    const Place& place = places[view];
    for (Vec2f& t : texcoords)
        t = {static_cast<float>((t.x * place.width + place.x) / picture.width),
             static_cast<float>((t.y * place.height + place.y) / picture.height)};
}

TextureAtlas make_atlas(const Image& left, const std::vector<PictureInUse>& others) {
    std::vector<PixelRect> parts, placed;
    // The parts lie in shelves below the left picture, as many beside each other as fit.
    int x = 0, y = whole_blocks(left.height), shelf = 0;
    for (const PictureInUse& view : others) {
        const PixelRect part = part_of(view);
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
    const std::size_t count = static_cast<std::size_t>(picture.width) * picture.height,
                      bytes = count * picture.channels;
    picture.pixels.reserve(bytes);
    picture.pixels = left.pixels;
    picture.pixels.resize(bytes);
    std::vector<char> is_known(count);
    std::fill_n(is_known.begin(), static_cast<std::size_t>(left.width) * left.height, 1);
    atlas.places.push_back({0, 0, static_cast<double>(left.width), static_cast<double>(left.height)});
    for (std::size_t i = 0; i < others.size(); ++i) {
        const Image& other = others[i].picture;
        const int to_x = placed[i].x - parts[i].x, to_y = placed[i].y - parts[i].y;
        for_used_runs(others[i], [&](int first, int end, int row) {
            for (int column = first; column < end; ++column) {
                copy_pixel(other.at(column, row), other.channels, picture.at(to_x + column, to_y + row),
                           picture.channels);
                is_known[static_cast<std::size_t>(to_y + row) * picture.width + to_x + column] = 1;
            }
        });
        atlas.places.push_back({static_cast<double>(to_x), static_cast<double>(to_y),
                                static_cast<double>(other.width), static_cast<double>(other.height)});
    }
    // In the order of a JPEG file whose colours are halved, so that its blocks of these have one colour, too.
    Colour before = {};
    for (int top = left.height / kWhole_px * kWhole_px; top < picture.height; top += kWhole_px)
        for (int column = 0; column < picture.width; column += kWhole_px)
            for (int v = top; v < std::min(top + kWhole_px, picture.height); v += kBlock_px)
                for (int u = column; u < std::min(column + kWhole_px, picture.width); u += kBlock_px)
                    before = fill_block(picture, is_known, u, v, before);
    return atlas;
}

}  // namespace hexrelief::stages
