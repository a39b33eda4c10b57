// What continues behind silhouettes, pixel by pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

// What continues behind a silhouette at each pixel.
struct Continued {
    static constexpr std::uint32_t kNoColour = std::numeric_limits<std::uint32_t>::max();

    Disparities disparities;              // kNotCovered = nothing
    RawVector<std::int32_t> distances;    // from the silhouette, px; 0 = in front, only colours are given
    RawVector<std::uint32_t> colours_of;  // the pixels whose colours it has
    std::vector<std::uint32_t> pixels;    // that have something
    std::vector<char> is_mixed = {};      // of the view: 1 = its colours may be mixed; empty = none are

    explicit Continued(std::size_t count) : disparities(count), distances(count), colours_of(count) {}

    // The nearest silhouette decides; of two, the farther surface. What continues goes before colours alone.
    void offer(std::size_t pixel, double d, int distance, std::size_t colour_of) {
        const auto rank_of = [](std::int32_t its_distance, std::size_t its_colour) {
            constexpr auto kLast = std::numeric_limits<std::int32_t>::max();
            return its_distance > 0 ? its_distance : its_colour == kNoColour ? kLast : kLast - 1;
        };
        if (disparities[pixel] != kNotCovered) {
            const int rank = rank_of(distance, colour_of), old = rank_of(distances[pixel], colours_of[pixel]);
            if (rank > old || (rank == old && d >= disparities[pixel])) return;
        }
        disparities[pixel] = d;
        distances[pixel] = distance;
        colours_of[pixel] = static_cast<std::uint32_t>(colour_of);
    }
};

// Lines may differ by this much and continue one surface.
inline constexpr double kNeighbours_px = 2;

// A step within the near thing, such as at its rim, is no silhouette: what continues there is part of the
// thing. Such a pixel's disparity is nearer to that of what hides it, `front`, than to the median of the
// means, over squares of radius_px / 16 px a side, of what continues within radius_px. The pixel gets what
// continues beside it, or nothing if that would not be hidden. So does a pixel without a colour; one in
// front gets the colour of one beside it that is in front. The same for any number of threads.
void give_scraps_away(Continued& continued, const Disparities& front, const ViewPlace& place, int radius_px,
                      ThreadPool& pool);

// Makes lines that continue one surface agree. The same for any number of threads.
void smooth(Continued& continued, const Disparities& front, const ViewPlace& place, ThreadPool& pool);

// Extends the colours by spread_px over pixels that hide what continues, so that a texture's filter finds no
// others there. missing: in the view, with what continues.
void spread_colours(Continued& continued, const DisparityMap& missing, const Disparities& front,
                    int spread_px);

// Paints what continues into a picture of any size: colours averaged over the pixels of one surface around
// each, as lines that continue beside each other have colours from different distances; the softer, the
// farther from the silhouette. seen: the colours, may be the picture itself. The same for any number of
// threads.
void paint(Image& picture, const Image& seen, const ViewPlace& place, const Continued& continued,
           ThreadPool& pool);

}  // namespace hexrelief::stages
