// A view in square cells, for the texture of what continues behind its silhouettes.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/image.h"
#include "pipeline/stages/other_views/continued.h"

namespace hexrelief::stages {

// From a target cell to its source, in cells.
struct Offset {
    std::int16_t x = 0, y = 0;
    bool operator==(const Offset&) const = default;
    bool is_none() const { return x == 0 && y == 0; }
};

// Cells, row by row, of which each is a source, a target, both or neither. Sources show one surface in clean
// colours; behind targets a surface continues that is to get a texture.
struct TextureLevel {
    using Colour = std::array<std::uint8_t, 4>;  // a picture's channels, and 1, or 0 without a colour
    using Light = std::array<float, 3>;          // levels of the channels
    static constexpr float kNoTarget = -1;       // as a tolerance

    int cell_px = 1;  // of the view
    int width = 0, height = 0;
    std::vector<char> is_source, is_mixed;
    std::vector<float> seen_at;    // disparities of the surface that the view shows
    std::vector<float> hidden_at;  // those of what continues
    // What is nearer than this to what continues at a target is of the same surface.
    std::vector<float> tolerances;
    std::vector<char> is_lenient;      // targets that found no source: their tolerance was doubled
    std::vector<Colour> seen, hidden;  // colours of sources, and those that targets have so far
    std::vector<Colour> guides;        // mean colours that targets should have about
    std::vector<Offset> offsets;
    std::vector<Light> light;  // of targets: what their sources' colours lack
    std::vector<std::uint32_t> targets;

    // Of a target, from the step at its silhouette, px.
    static float tolerance_of(double step_px);

    TextureLevel(int cell_px, int width, int height);
    int at(int x, int y) const { return y * width + x; }
    bool has(int x, int y) const { return x >= 0 && x < width && y >= 0 && y < height; }
    bool is_target(std::size_t cell) const { return tolerances[cell] >= 0; }
    bool are_one(std::size_t target, std::size_t other) const {
        return std::abs(hidden_at[target] - hidden_at[other]) <= tolerances[target];
    }
    // How far the surface of a source is from what continues at a target, in the target's tolerance.
    float apart(std::size_t target, std::size_t source) const {
        return std::abs(hidden_at[target] - seen_at[source]) / tolerances[target];
    }
    bool is_source_of(std::size_t target, std::size_t cell) const {
        return is_source[cell] && std::abs(hidden_at[target] - seen_at[cell]) <= tolerances[target];
    }
};

// Returns the view in cells of cell_px pixels a side. Cells of mixed colours between targets and sources are
// targets as well. front: the disparities of the view. The same for any number of threads.
TextureLevel finest_level(const Image& picture, const ViewPlace& place, const Continued& continued,
                          const Disparities& front, int cell_px, ThreadPool& pool);
// Returns it in cells twice as wide.
TextureLevel coarser_level(const TextureLevel& fine, ThreadPool& pool);

}  // namespace hexrelief::stages
