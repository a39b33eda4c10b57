#include "pipeline/stages/other_views/continued.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pipeline/data/four_neighbours.h"

namespace hexrelief::stages {
namespace {

constexpr int kSmoothings = 8;  // across the lines along which surfaces continue
// Averages of colours: over squares of this radius, px, and more by the distance from the silhouette divided
// by the second number; of so many pixels a side at most.
constexpr int kSoft_px = 2, kSofterEvery = 3, kTaps = 9;
constexpr int kMostBetween_px = 7;  // the sum of the levels of 15 x 15 pixels has 16 bits
constexpr int kBlocksAround = 16;   // along a radius within which a median is taken

// Returns for each square of `side` px the median of what continues within some squares of it.
std::vector<double> medians_of(const Continued& continued, const ViewPlace& place, int side, int around,
                               ThreadPool& pool) {
    const int columns = (place.width + side - 1) / side, rows = (place.height + side - 1) / side;
    std::vector<double> sums(static_cast<std::size_t>(columns) * rows), medians(sums.size(), kNotCovered);
    std::vector<int> counts(sums.size());
    for (const std::uint32_t pixel : continued.pixels) {
        if (continued.distances[pixel] == 0) continue;
        const int column = static_cast<int>(pixel % place.width) / side,
                  row = static_cast<int>(pixel / place.width) / side;
        const std::size_t i = static_cast<std::size_t>(row) * columns + column;
        sums[i] += continued.disparities[pixel];
        ++counts[i];
    }
    pool.parallel_for_chunks<1>(static_cast<std::size_t>(rows), [&](std::size_t at) {
        const int row = static_cast<int>(at);
        std::vector<double> values;
        for (int column = 0; column < columns; ++column) {
            const std::size_t here = static_cast<std::size_t>(row) * columns + column;
            if (counts[here] == 0) continue;
            values.clear();
            for (int v = std::max(0, row - around); v <= std::min(rows - 1, row + around); ++v)
                for (int u = std::max(0, column - around); u <= std::min(columns - 1, column + around); ++u)
                    if (const std::size_t i = static_cast<std::size_t>(v) * columns + u; counts[i] > 0)
                        values.push_back(sums[i] / counts[i]);
            medians[here] = value_at_rank(values, values.size() / 2);
        }
    });
    return medians;
}

}  // namespace

void give_scraps_away(Continued& continued, const Disparities& front, const ViewPlace& place, int radius_px,
                      ThreadPool& pool) {
    const int side = std::max(1, radius_px / kBlocksAround), columns = (place.width + side - 1) / side;
    const std::vector<double> medians = medians_of(continued, place, side, radius_px / side, pool);
    Disparities& disparities = continued.disparities;
    std::vector<std::uint32_t> open;
    for (const std::uint32_t pixel : continued.pixels) {
        const std::size_t square = pixel / place.width / side * columns + pixel % place.width / side;
        if (continued.colours_of[pixel] == Continued::kNoColour ||
            (continued.distances[pixel] > 0 && 2 * disparities[pixel] > front[pixel] + medians[square]))
            open.push_back(pixel);
    }
    for (const std::uint32_t pixel : open) disparities[pixel] = kNotCovered;
    const auto is_in_front = [&](std::size_t i) { return continued.distances[i] == 0; };
    // What is beside them grows by a pixel a round.
    for (std::size_t given = 1; given > 0;) {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> now;  // a pixel and the one that it follows
        std::vector<std::uint32_t> still;
        for (const std::uint32_t pixel : open) {
            std::uint32_t from = pixel;
            for_four_neighbours(pixel, place.width, place.height, [&](std::size_t i) {
                if (disparities[i] == kNotCovered || is_in_front(i) != is_in_front(pixel)) return;
                const double nearer = front[pixel] - disparities[i];
                if (is_in_front(pixel) ? std::abs(nearer) > kOneSurface_px : nearer <= kOneSurface_px) return;
                if (from == pixel || disparities[i] < disparities[from]) from = static_cast<std::uint32_t>(i);
            });
            if (from == pixel)
                still.push_back(pixel);
            else
                now.emplace_back(pixel, from);
        }
        for (const auto& [pixel, from] : now) {
            disparities[pixel] = is_in_front(pixel) ? front[pixel] : disparities[from];
            if (!is_in_front(pixel)) continued.distances[pixel] = continued.distances[from] + 1;
            continued.colours_of[pixel] = continued.colours_of[from];
        }
        given = now.size();
        open = std::move(still);
    }
    std::erase_if(continued.pixels, [&](std::uint32_t pixel) { return disparities[pixel] == kNotCovered; });
}

void smooth(Continued& continued, const Disparities& front, const ViewPlace& place, ThreadPool& pool) {
    const std::vector<std::uint32_t>& pixels = continued.pixels;
    Disparities& disparities = continued.disparities;
    std::vector<double> smoothed(pixels.size());
    const auto smooth_at = [&](std::uint32_t pixel) {
        const double own = disparities[pixel];
        double sum = own;
        int count = 1;
        for_four_neighbours(pixel, place.width, place.height, [&](std::size_t other) {
            const double d = disparities[other] == kNotCovered ? front[other] : disparities[other];
            if (std::abs(d - own) > kNeighbours_px) return;
            sum += d;
            ++count;
        });
        return sum / count;
    };
    pool.run([&](int thread) {
        const std::size_t begin = pool.share(pixels.size(), thread),
                          end = pool.share(pixels.size(), thread + 1);
        for (int round = 0; round < kSmoothings; ++round) {
            for (std::size_t i = begin; i < end; ++i) smoothed[i] = smooth_at(pixels[i]);
            pool.barrier();
            for (std::size_t i = begin; i < end; ++i) disparities[pixels[i]] = smoothed[i];
            pool.barrier();
        }
    });
}

void spread_colours(Continued& continued, const DisparityMap& missing, const Disparities& front,
                    int spread_px) {
    std::size_t begin = 0;
    for (int round = 0; round < spread_px; ++round) {
        const std::size_t end = continued.pixels.size();
        for (; begin < end; ++begin) {
            const std::uint32_t from = continued.pixels[begin];
            for_four_neighbours(from, missing.width, missing.height, [&](std::size_t i) {
                if (continued.disparities[i] != kNotCovered || DisparityMap::known(missing.values[i]) ||
                    (front[i] != kNotCovered && front[i] - continued.disparities[from] <= kOneSurface_px))
                    return;
                continued.disparities[i] = continued.disparities[from];
                continued.colours_of[i] = continued.colours_of[from];
                continued.distances[i] = std::max(1, continued.distances[from]);  // it is not cleaned
                continued.pixels.push_back(static_cast<std::uint32_t>(i));
            });
        }
    }
}

void paint(Image& picture, const Image& seen, const ViewPlace& place, const Continued& continued,
           ThreadPool& pool) {
    if (picture.empty()) return;
    const auto column = [&](int x) { return x * picture.width / place.width; };
    const auto row = [&](int y) { return y * picture.height / place.height; };
    const auto width = static_cast<std::uint32_t>(place.width);
    // A channel has 16 bits of a sum, the last 16 bits are the count.
    constexpr int kBits = 16, kCount = 48;
    const auto packed = [&](const auto& colour) {
        std::uint64_t sums = std::uint64_t{1} << kCount;
        for (int c = 0; c < picture.channels; ++c) sums |= std::uint64_t(colour[c]) << kBits * c;
        return sums;
    };
    const auto colour_of = [&](std::size_t pixel) {
        return packed(seen.at(column(static_cast<int>(pixel % width)), row(static_cast<int>(pixel / width))));
    };
    using Levels = std::array<int, 3>;
    const auto levels_of = [&](std::uint64_t sums) {
        const std::uint64_t count = sums >> kCount;
        Levels levels = {};
        for (int c = 0; c < picture.channels; ++c)
            levels[c] = static_cast<int>(((sums >> kBits * c & 0xffff) + count / 2) / count);
        return levels;
    };
    const auto radius_of = [&](std::uint32_t pixel) {
        return kSoft_px + continued.distances[pixel] / kSofterEvery;
    };
    const auto stride_of = [&](std::uint32_t pixel) { return 1 + 2 * radius_of(pixel) / kTaps; };
    const auto mean_around = [&](std::uint32_t pixel, int radius, int stride,
                                 const RawVector<std::uint64_t>& colours) {
        const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
        std::uint64_t sums = 0;
        for (int v = y - radius / stride * stride; v <= y + radius; v += stride) {
            if (v < 0 || v >= place.height) continue;
            for (int u = x - radius / stride * stride; u <= x + radius; u += stride) {
                if (u < 0 || u >= place.width) continue;
                const std::size_t other = static_cast<std::size_t>(v) * width + u;
                if (std::abs(continued.disparities[other] - continued.disparities[pixel]) <= kNeighbours_px)
                    sums += colours[other];
            }
        }
        return levels_of(sums);
    };
    // The colours are taken before any pixel is painted.
    RawVector<std::uint64_t> colours(continued.disparities.size());
    pool.parallel_for_chunks(continued.pixels.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            colours[continued.pixels[i]] = colour_of(continued.colours_of[continued.pixels[i]]);
    });
    // Pixels a stride apart share what is added up, so what lies between is averaged again.
    RawVector<std::uint64_t> means(colours.size());
    pool.parallel_for_chunks(continued.pixels.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t pixel = continued.pixels[i];
            means[pixel] = packed(mean_around(pixel, radius_of(pixel), stride_of(pixel), colours));
        }
    });
    const auto paint_at = [&](std::size_t i) {
        const std::uint32_t pixel = continued.pixels[i];
        const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
        if (column(x) == column(x + 1) || row(y) == row(y + 1))
            return;  // a smaller picture has no such pixel
        const Levels mean = mean_around(pixel, std::min(stride_of(pixel) / 2, kMostBetween_px), 1, means);
        std::uint8_t colour[3] = {};
        for (int c = 0; c < picture.channels; ++c) colour[c] = static_cast<std::uint8_t>(mean[c]);
        for (int v = row(y); v < row(y + 1); ++v)
            for (int u = column(x); u < column(x + 1); ++u)
                std::copy_n(colour, picture.channels, picture.at(u, v));
    };
    pool.parallel_for_chunks(continued.pixels.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) paint_at(i);
    });
}

}  // namespace hexrelief::stages
