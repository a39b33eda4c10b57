#include "pipeline/stages/other_views/texture_atlas.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/union_find.h"
#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {
namespace {

constexpr int kBlock_px = 8;   // of a JPEG file
constexpr int kBeside_px = 1;  // what is so near a used pixel is used, too: it is interpolated with it
constexpr int kSmoothingRounds = 8;

int blocks_in(int px) {
    return (px + kAtlasBlock_px - 1) / kAtlasBlock_px;
}

// Calls take(first, end, y) for the used pixels of each row and what lies beside them; some come several
// times.
template <typename Take>
void for_used_runs(const std::vector<char>& used, int width, int height, const Take& take) {
    for (int y = 0; y < height; ++y) {
        const auto row = used.begin() + static_cast<std::ptrdiff_t>(y) * width, row_end = row + width;
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

// The blocks of a picture, row by row.
struct Blocks {
    Blocks(int width_px, int height_px)
        : width(width_px), height(height_px), columns(blocks_in(width_px)), rows(blocks_in(height_px)) {}
    int width, height;  // of the picture, px
    int columns, rows;

    std::uint32_t at(int x_px, int y_px) const {
        const int column = std::clamp(x_px / kAtlasBlock_px, 0, columns - 1),
                  row = std::clamp(y_px / kAtlasBlock_px, 0, rows - 1);
        return static_cast<std::uint32_t>(row * columns + column);
    }
    std::size_t size() const { return static_cast<std::size_t>(columns) * rows; }
    std::uint32_t at(const Vec2f& t) const {
        return at(static_cast<int>(t.x * static_cast<float>(width)),
                  static_cast<int>(t.y * static_cast<float>(height)));
    }
};

Blocks blocks_of(const Image& picture) {
    return {picture.width, picture.height};
}

// Blocks of one picture that keep their places relative to each other.
struct Chart {
    std::size_t view = 0;
    std::vector<std::uint32_t> blocks;
    int left = 0, top = 0, right = 0, bottom = 0;  // blocks; right and bottom are beyond the last
};

std::vector<Chart> charts_of(const std::vector<PictureInUse>& views) {
    std::vector<Chart> charts;
    for (std::size_t view = 0; view < views.size(); ++view) {
        const Blocks blocks = blocks_of(views[view].picture);
        const std::vector<std::uint32_t>& names = views[view].used.charts;
        std::vector<std::size_t> number(names.size());
        for (std::uint32_t i = 0; i < names.size(); ++i) {
            if (names[i] == kNoChart) continue;
            const int x = static_cast<int>(i) % blocks.columns, y = static_cast<int>(i) / blocks.columns;
            if (names[i] == i) {  // a chart is named by its first block
                number[i] = charts.size();
                charts.push_back({view, {}, x, y, x, y});
            }
            Chart& chart = charts[number[names[i]]];
            chart.blocks.push_back(i);
            chart.left = std::min(chart.left, x);
            chart.right = std::max(chart.right, x + 1);
            chart.bottom = y + 1;
        }
    }
    std::ranges::stable_sort(charts, std::greater(), [](const Chart& chart) { return chart.blocks.size(); });
    return charts;
}

// The blocks below the left picture, given to charts.
class Shelf {
  public:
    // columns: as many as the widest chart has, at least.
    Shelf(int width_px, int columns) : width_px_(width_px), columns_(columns) {}
    int rows() const { return static_cast<int>(taken_.size()) / columns_; }

    // Takes the first free place, row by row, where all of the chart's blocks find room. Returns its corner.
    std::array<int, 2> place(const Chart& chart, const Blocks& blocks) {
        const int height = chart.bottom - chart.top;
        const int width_px =
            std::min(chart.right * kAtlasBlock_px, blocks.width) - chart.left * kAtlasBlock_px;
        for (int y = 0;; ++y) {
            if (rows() < y + height) taken_.resize(static_cast<std::size_t>(y + height) * columns_);
            for (int x = 0; x == 0 || x * kAtlasBlock_px + width_px <= width_px_; ++x) {
                const auto cell = [&](std::uint32_t block) -> char& {
                    const int column = static_cast<int>(block) % blocks.columns - chart.left + x,
                              row = static_cast<int>(block) / blocks.columns - chart.top + y;
                    return taken_[static_cast<std::size_t>(row) * columns_ + column];
                };
                if (std::ranges::any_of(chart.blocks, cell)) continue;
                for (const std::uint32_t block : chart.blocks) cell(block) = 1;
                return {x, y};
            }
        }
    }

  private:
    int width_px_, columns_;
    std::vector<char> taken_;  // row by row
};

void copy_pixel(const std::uint8_t* from, int from_channels, std::uint8_t* to, int to_channels) {
    if (from_channels == to_channels)
        std::copy_n(from, to_channels, to);
    else if (from_channels == 1)
        std::fill_n(to, to_channels, from[0]);
    else
        to[0] = static_cast<std::uint8_t>((from[0] + 2 * from[1] + from[2]) / 4);
}

using AtlasColour = std::array<float, 3>;

// Gives the pixels of a block that have no colour those that a JPEG file needs fewest bytes for: what goes on
// smoothly from the block's others, or if it has none the mean of the block before. Returns the block's mean.
// is_known: 1 for pixels with a colour, row by row of the atlas from the block's first row on.
AtlasColour fill_block(Image& atlas, const char* is_known, int x, int y, const AtlasColour& before) {
    const int width = std::min(kBlock_px, atlas.width - x), height = std::min(kBlock_px, atlas.height - y);
    std::array<AtlasColour, kBlock_px * kBlock_px> colours;
    std::array<char, kBlock_px*kBlock_px> has_colour = {}, is_given;
    const auto for_pixels = [&](const auto& visit) {
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u) visit(u, v, v * kBlock_px + u);
    };
    bool is_empty = true, is_full = true;
    for_pixels([&](int u, int v, int i) {
        has_colour[i] = is_known[static_cast<std::size_t>(v) * atlas.width + x + u];
        is_empty &= !has_colour[i];
        is_full &= has_colour[i] != 0;
        colours[i] = before;
        if (has_colour[i]) std::copy_n(atlas.at(x + u, y + v), atlas.channels, colours[i].begin());
    });
    is_given = has_colour;
    const auto interpolate = [&](int u, int v, int i) {
        if (is_given[i]) return;
        AtlasColour sum = {};
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
    AtlasColour mean = {};
    for_pixels([&](int u, int v, int i) {
        for (int c = 0; c < atlas.channels; ++c) {
            mean[c] += colours[i][c] / static_cast<float>(width * height);
            if (!is_given[i]) atlas.at(x + u, y + v)[c] = static_cast<std::uint8_t>(colours[i][c] + 0.5f);
        }
    });
    return mean;
}

}  // namespace

UsedPart used_part(const Image& picture, const SurfaceMesh& sheet, bool stays_whole, int threads) {
    const int width = picture.width, height = picture.height;
    View view{{}, &sheet.triangles, width, height};
    for (const Vec2f& t : sheet.texcoords)
        view.points.push_back({static_cast<double>(t.x) * width, static_cast<double>(t.y) * height, 0});
    UsedPart part{rasterise_coverage(view, threads), {}};

    const Blocks blocks = blocks_of(picture);
    UnionFind sets(blocks.size());
    part.charts.assign(blocks.size(), kNoChart);
    const auto use = [&](std::uint32_t block) { return part.charts[block] = block; };
    for_used_runs(part.pixels, width, height, [&](int first, int end, int y) {
        for (std::uint32_t i = blocks.at(first, y); i <= blocks.at(end - 1, y); ++i) use(i);
    });
    for (const Triangle& t : sheet.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            sets.join(use(blocks.at(sheet.texcoords[t[0]])), use(blocks.at(sheet.texcoords[t[k]])));
    for (int y = 0; y < blocks.rows; ++y)
        for (int x = 0; x < blocks.columns; ++x) {
            const auto join = [&](int u, int v) {
                if (u < 0 || u == blocks.columns || v == blocks.rows) return;
                const std::uint32_t here = y * blocks.columns + x, there = v * blocks.columns + u;
                if (part.charts[here] != kNoChart && part.charts[there] != kNoChart) sets.join(here, there);
            };
            join(x + 1, y);
            for (int u = x - 1; u <= x + 1; ++u) join(u, y + 1);
        }
    for (std::uint32_t i = 0; i < part.charts.size(); ++i)
        if (stays_whole)
            part.charts[i] = 0;
        else if (part.charts[i] != kNoChart)
            part.charts[i] = sets.find(i);
    return part;
}

void TextureAtlas::move_in(std::span<Vec2f> texcoords, std::size_t view) const {
    const Place& place = places[view];
    const Blocks blocks(place.width, place.height);
    for (Vec2f& t : texcoords) {
        const auto& [x, y] = place.shifts[blocks.at(t)];
        t = {static_cast<float>((static_cast<double>(t.x) * place.width + x) / picture.width),
             static_cast<float>((static_cast<double>(t.y) * place.height + y) / picture.height)};
    }
}

Image with_room_below(const Image& left) {
    constexpr std::size_t kRoom = 2;  // times the picture; memory that nothing is written to costs nothing
    Image copy{left.width, left.height, left.channels, {}};
    copy.pixels.reserve(kRoom * left.pixels.size());
    copy.pixels = left.pixels;
    return copy;
}

TextureAtlas make_atlas(Image left, const std::vector<PictureInUse>& others, int threads) {
    const std::vector<Chart> charts = charts_of(others);
    TextureAtlas atlas;
    atlas.places.push_back({left.width, left.height, {blocks_of(left).size(), {0, 0}}});
    for (const PictureInUse& view : others)
        atlas.places.push_back({view.picture.width, view.picture.height, {view.used.charts.size(), {0, 0}}});
    int columns = blocks_in(left.width);
    for (const Chart& chart : charts) columns = std::max(columns, chart.right - chart.left);
    Shelf shelf(left.width, columns);
    const int below = blocks_in(left.height);
    for (const Chart& chart : charts) {
        const auto [x, y] = shelf.place(chart, blocks_of(others[chart.view].picture));
        for (const std::uint32_t block : chart.blocks)
            atlas.places[chart.view + 1].shifts[block] = {(x - chart.left) * kAtlasBlock_px,
                                                          (below + y - chart.top) * kAtlasBlock_px};
    }

    // The rows of blocks that the left picture does not fill.
    const int first_row = left.height / kAtlasBlock_px, rows = below + shelf.rows() - first_row;
    const int first_y = first_row * kAtlasBlock_px, left_height = left.height;
    AtlasColour last_row = {};
    std::copy_n(left.at(0, left.height - 1), left.channels, last_row.begin());
    Image& picture = atlas.picture = std::move(left);
    picture.height = (below + shelf.rows()) * kAtlasBlock_px;
    picture.pixels.resize(static_cast<std::size_t>(picture.width) * picture.height * picture.channels);
    const auto row_of = [&](int y) { return static_cast<std::size_t>(y - first_y) * picture.width; };
    std::vector<char> is_known(row_of(picture.height));
    std::fill_n(is_known.begin(), row_of(left_height), 1);
    for (std::size_t i = 0; i < others.size(); ++i) {
        const Image& other = others[i].picture;
        const Blocks blocks = blocks_of(other);
        for_used_runs(others[i].used.pixels, other.width, other.height, [&](int first, int end, int row) {
            const auto& [x, y] = atlas.places[i + 1].shifts[blocks.at(first, row)];
            for (int column = first; column < std::min(end, picture.width - x); ++column) {
                copy_pixel(other.at(column, row), other.channels, picture.at(column + x, row + y),
                           picture.channels);
                is_known[row_of(row + y) + column + x] = 1;
            }
        });
    }
    // In the order of a JPEG file whose colours are halved, so that its blocks of these have one colour, too.
    ThreadPool(threads).parallel_for_chunks<1>(rows, [&](std::size_t row) {
        const int top = (first_row + static_cast<int>(row)) * kAtlasBlock_px,
                  bottom = std::min(top + kAtlasBlock_px, picture.height);
        AtlasColour before = last_row;
        for (int column = 0; column < picture.width; column += kAtlasBlock_px)
            for (int v = top; v < bottom; v += kBlock_px)
                for (int u = column; u < std::min(column + kAtlasBlock_px, picture.width); u += kBlock_px)
                    before = fill_block(picture, &is_known[row_of(v)], u, v, before);
    });
    return atlas;
}

}  // namespace hexrelief::stages
