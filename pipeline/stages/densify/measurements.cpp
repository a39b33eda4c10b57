#include "pipeline/stages/densify/measurements.h"

namespace hexrelief::stages {
namespace {

constexpr std::uint32_t kStraight = kDistanceOne, kDiagonal = 23, kFar = 0x7fffffffu;
constexpr std::uint32_t kColor = kDistanceOne;  // cost of a colour step of 1

struct Sweep {
    int width, height;
    const Image& left;
    NearestMeasurements& nearest;

    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }

    void relax(int x, int y, int from_x, int from_y, std::uint32_t length) {
        if (from_x < 0 || from_x >= width || from_y < 0 || from_y >= height) return;
        const std::size_t own = at(x, y), from = at(from_x, from_y);
        std::uint32_t way = nearest.distance[from] + length;
        if (way >= nearest.distance[own]) return;
        if (!left.empty())
            way += kColor * static_cast<std::uint32_t>(
                                color_step(left.at(x, y), left.at(from_x, from_y), left.channels));
        if (way >= nearest.distance[own]) return;
        nearest.distance[own] = way;
        nearest.index[own] = nearest.index[from];
    }
    void downwards() {
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                relax(x, y, x - 1, y - 1, kDiagonal);
                relax(x, y, x, y - 1, kStraight);
                relax(x, y, x + 1, y - 1, kDiagonal);
                relax(x, y, x - 1, y, kStraight);
            }
            for (int x = width - 2; x >= 0; --x) relax(x, y, x + 1, y, kStraight);
        }
    }
    void upwards() {
        for (int y = height - 1; y >= 0; --y) {
            for (int x = width - 1; x >= 0; --x) {
                relax(x, y, x + 1, y + 1, kDiagonal);
                relax(x, y, x, y + 1, kStraight);
                relax(x, y, x - 1, y + 1, kDiagonal);
                relax(x, y, x + 1, y, kStraight);
            }
            for (int x = 1; x < width; ++x) relax(x, y, x - 1, y, kStraight);
        }
    }
};

}  // namespace

std::vector<PlaneAt> measurements_of(const DisparityMap& map) {
    std::vector<PlaneAt> found;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (DisparityMap::known(map.at(x, y))) found.push_back({x, y, map.at(x, y)});
    return found;
}

NearestMeasurements find_nearest(const std::vector<PlaneAt>& measurements, int width, int height,
                                 const Image& left) {
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    NearestMeasurements nearest{width, height, std::vector<std::uint32_t>(pixels, kNoMeasurement),
                                std::vector<std::uint32_t>(pixels, kFar)};
    Sweep sweep{width, height, left, nearest};
    for (std::size_t i = 0; i < measurements.size(); ++i) {
        const std::size_t at = sweep.at(measurements[i].x, measurements[i].y);
        nearest.index[at] = static_cast<std::uint32_t>(i);
        nearest.distance[at] = 0;
    }
    for (int round = 0; round < (left.empty() ? 1 : 2); ++round) {
        sweep.downwards();
        sweep.upwards();
    }
    return nearest;
}

}  // namespace hexrelief::stages
