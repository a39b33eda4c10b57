#include "mesher/tiles/lattice_tiles.h"

#include <algorithm>
#include <cmath>

#include "mesher/som/level_transfer_step.h"

namespace hexrelief::mesh_tiles {
namespace {

std::int32_t to_place(double px) {
    return static_cast<std::int32_t>(std::floor(px * kPlacesPerPixel + 0.5));
}

// px by which a seam may deviate from its position in the coarse lattice.
constexpr int kSpreadMargin_px = 64;

// Spreads the moves of the seams' vertices to all others, so that nothing folds between them: each vertex
// takes the mean of its neighbours' moves, in several sweeps.
void spread(std::vector<Vec2f>& moves, const std::vector<std::uint8_t>& known, int columns, int rows) {
    constexpr int kSweeps = 40;
    std::vector<Vec2f> next = moves;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        for (int row = 1; row + 1 < rows; ++row)
            for (int column = 1; column + 1 < columns; ++column) {
                const std::size_t i = static_cast<std::size_t>(row) * columns + column;
                if (known[i]) continue;
                const Vec2f &up = moves[i - columns], &down = moves[i + columns], &left = moves[i - 1],
                            &right = moves[i + 1];
                next[i] = {((up.x + down.x) + (left.x + right.x)) / 4,
                           ((up.y + down.y) + (left.y + right.y)) / 4};
            }
        moves.swap(next);
    }
}

// Reads one coordinate of all vertices in place.
struct CoordinateOf {
    const std::vector<Vec2f>& positions;
    float Vec2f::*coordinate;
    float operator[](std::size_t i) const { return positions[i].*coordinate; }
};

LatticeBlock part_of(const LatticeBlock& block, int first_row, int end_row, int first_column,
                     int end_column) {
    LatticeBlock part{first_column, first_row, end_column - first_column, end_row - first_row, {}};
    for (int row = first_row; row < end_row; ++row)
        for (int column = first_column; column < end_column; ++column)
            part.places.push_back(block.at(column, row));
    return part;
}

}  // namespace

Vec2f in_window(const Place& p, const MapRect& w) {
    return {static_cast<float>(p.x - w.x * kPlacesPerPixel) / kPlacesPerPixel,
            static_cast<float>(p.y - w.y * kPlacesPerPixel) / kPlacesPerPixel};
}

Place place_of(const Vec2f& p, const MapRect& w) {
    return {w.x * kPlacesPerPixel + to_place(p.x), w.y * kPlacesPerPixel + to_place(p.y)};
}

LatticeTiling::LatticeTiling(int columns, int rows, int spacings)
    : columns_(columns), rows_(rows), spacings_(std::max(spacings / 6 * 6, kLeastTile)) {
    const auto tiles = [&](int vertices) { return std::max(1, (vertices - 1 + spacings_ / 2) / spacings_); };
    across_ = tiles(columns);
    down_ = tiles(rows);
}

MapRect window_of(const LatticeBlock& block, int margin_px, int width, int height) {
    Place least = block.places.front(), most = least;
    for (const Place& p : block.places) {
        least = {std::min(least.x, p.x), std::min(least.y, p.y)};
        most = {std::max(most.x, p.x), std::max(most.y, p.y)};
    }
    // rounded outwards to whole px; the upper left corner is a multiple of 4, the side of the tiles in
    // which discontinuities are counted
    const auto below = [&](std::int32_t at) {
        return std::max(0, (at / kPlacesPerPixel - margin_px) / 4 * 4);
    };
    const auto above = [&](std::int32_t at, int size) {
        return std::min(size, at / kPlacesPerPixel + 1 + margin_px);
    };
    const int x = below(least.x), y = below(least.y);
    return {x, y, above(most.x, width) - x, above(most.y, height) - y};
}

// Returns a block within the lattice, with places interpolated from the coarse lattice.
LatticeBlock TileSolver::block(int first_column, int first_row, int end_column, int end_row) const {
    LatticeBlock found;
    found.first_column = std::max(0, first_column);
    found.first_row = std::max(0, first_row);
    found.columns = std::min(tiling_.columns(), end_column) - found.first_column;
    found.rows = std::min(tiling_.rows(), end_row) - found.first_row;
    const step::Refinement refinement{
        {coarse_.mesh.columns, coarse_.mesh.rows}, {tiling_.columns(), tiling_.rows()}, true};
    const CoordinateOf xs{coarse_.mesh.positions, &Vec2f::x}, ys{coarse_.mesh.positions, &Vec2f::y};
    const auto place = [&](const CoordinateOf& values, int column, int row, int size) {
        const double px =
            static_cast<double>(step::interpolated(values, refinement, column, row)) * coarse_.shrunk_by;
        return to_place(std::clamp(px, 0.0, static_cast<double>(size)));
    };
    found.places.reserve(static_cast<std::size_t>(found.columns) * found.rows);
    for (int row = found.first_row; row < found.end_row(); ++row)
        for (int column = found.first_column; column < found.end_column(); ++column)
            found.places.push_back(
                {place(xs, column, row, coarse_.width), place(ys, column, row, coarse_.height)});
    return found;
}

// Moves a block's vertices to their places in the seams, spreads these moves, and balances the block.
void TileSolver::balance(std::span<const Seam* const> seams, LatticeBlock& block) const {
    std::vector<std::uint8_t> held(block.places.size(), 0), known = held;
    std::vector<Vec2f> moves(block.places.size());  // px, from the vertex's position in the coarse lattice
    for (const Seam* const seam : seams) {
        if (!seam) continue;
        const LatticeBlock& of = seam->block;
        for (int row = std::max(block.first_row, of.first_row); row < std::min(block.end_row(), of.end_row());
             ++row)
            for (int column = std::max(block.first_column, of.first_column);
                 column < std::min(block.end_column(), of.end_column()); ++column) {
                const std::size_t i = static_cast<std::size_t>(row - block.first_row) * block.columns +
                                      (column - block.first_column);
                const Place from = block.places[i], to = of.at(column, row);
                moves[i] = {static_cast<float>(to.x - from.x) / kPlacesPerPixel,
                            static_cast<float>(to.y - from.y) / kPlacesPerPixel};
                known[i] = 1;
                held[i] |= seam->holds(column, row);
            }
    }
    spread(moves, known, block.columns, block.rows);
    const MapRect window = window_of(block, kSpreadMargin_px, coarse_.width, coarse_.height);
    balance::LatticePatch patch{{block.columns, block.rows, {}}, std::move(held)};
    patch.mesh.positions.reserve(block.places.size());
    for (std::size_t i = 0; i < block.places.size(); ++i) {
        const Vec2f p = in_window(block.places[i], window);
        patch.mesh.positions.push_back(
            {std::clamp(p.x + moves[i].x, 0.0f, static_cast<float>(window.width)),
             std::clamp(p.y + moves[i].y, 0.0f, static_cast<float>(window.height))});
    }
    balance_(density_(window), config_, threads_, patch);
    for (std::size_t i = 0; i < block.places.size(); ++i)
        block.places[i] = place_of(patch.mesh.positions[i], window);
}

Seam TileSolver::row_seam(int j) const {
    const int row = tiling_.row_of(j), beyond = kSeamRings + kSeamBeyond, columns = tiling_.columns();
    LatticeBlock found = block(0, row - beyond, columns, row + beyond + 1);
    balance({}, found);
    return {part_of(found, row - kSeamRings, row + kSeamRings + 1, 0, columns), 0, row - kHeldRings, columns,
            row + kHeldRings + 1};
}

Seam TileSolver::column_seam(int i, int j, const Seam* above, const Seam* below) const {
    const int column = tiling_.column_of(i), beyond = kSeamRings + kSeamBeyond;
    LatticeBlock found = block(column - beyond, tiling_.row_of(j) - kHeldRings, column + beyond + 1,
                               tiling_.row_of(j + 1) + kHeldRings + 1);
    balance(std::array{above, below}, found);
    return {part_of(found, found.first_row, found.end_row(), column - kSeamRings, column + kSeamRings + 1),
            column - kHeldRings, found.first_row, column + kHeldRings + 1, found.end_row()};
}

LatticeBlock TileSolver::tile(int i, int j, const std::array<const Seam*, 4>& seams) const {
    LatticeBlock found =
        block(tiling_.column_of(i) - kHeldRings, tiling_.row_of(j) - kHeldRings,
              tiling_.column_of(i + 1) + kHeldRings + 1, tiling_.row_of(j + 1) + kHeldRings + 1);
    balance(seams, found);
    return found;
}

}  // namespace hexrelief::mesh_tiles
