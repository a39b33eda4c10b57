#include "turned_pair.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace hexrelief::alignment {
namespace {

using Vector = std::array<double, 3>;

double to_radians(double degrees) {
    return degrees * std::acos(-1.0) / 180;
}

Vector turned_about(std::size_t axis, double degrees, Vector v) {
    const double c = std::cos(to_radians(degrees)), s = std::sin(to_radians(degrees));
    const std::size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double va = v[a], vb = v[b];
    v[a] = c * va - s * vb;
    v[b] = s * va + c * vb;
    return v;
}

double hashed(std::int64_t x, std::int64_t y, unsigned seed) {
    std::uint32_t v = static_cast<std::uint32_t>(x) * 2654435761u ^
                      static_cast<std::uint32_t>(y) * 2246822519u ^ seed * 3266489917u;
    v = (v ^ (v >> 15)) * 2246822519u;
    v = (v ^ (v >> 13)) * 3266489917u;
    return ((v ^ (v >> 16)) & 0xffff) / 65535.0;
}

// Smooth noise, whose grid has a step of 1.
double noise(double x, double y, unsigned seed) {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const auto ease = [](double t) { return t * t * (3 - 2 * t); };
    const double u = ease(x - fx), v = ease(y - fy);
    const auto row = [&](std::int64_t j) {
        return (1 - u) * hashed(ix, j, seed) + u * hashed(ix + 1, j, seed);
    };
    return (1 - v) * row(iy) + v * row(iy + 1);
}

double texture(double x, double y, unsigned seed) {
    return 0.3 * noise(9 * x, 9 * y, seed) + 0.4 * noise(23 * x, 23 * y, seed + 1) +
           0.3 * noise(51 * x, 51 * y, seed + 2);
}

struct Board {
    double x, y, half_width, half_height, z;
};

constexpr std::array<Board, 6> kBoards = {{{-0.9, -0.4, 0.35, 0.4, 2.4},
                                           {0.8, 0.3, 0.4, 0.35, 2.0},
                                           {0.1, -0.7, 0.5, 0.3, 3.0},
                                           {-1.2, 0.9, 0.6, 0.4, 3.6},
                                           {1.7, -0.8, 0.6, 0.6, 4.2},
                                           {-0.1, 0.4, 0.4, 0.5, 5.0}}};

// Returns the light that a ray from (x, y, z) meets, 0 to 1.
double light(const Vector& from, const Vector& ray, unsigned seed) {
    double nearest = 6 + 0.1 * ray[0];  // the wall
    unsigned surface = seed;
    if (const double floor = (1.4 - from[1]) / ray[1] + from[2]; ray[1] > 0 && floor > 0 && floor < nearest) {
        nearest = floor;
        surface = seed + 50;
    }
    for (const Board& board : kBoards) {
        const double x = from[0] + ray[0] * (board.z - from[2]), y = from[1] + ray[1] * (board.z - from[2]);
        if (board.z < nearest && std::fabs(x - board.x) < board.half_width &&
            std::fabs(y - board.y) < board.half_height) {
            nearest = board.z;
            surface = seed + 10 * static_cast<unsigned>(&board - kBoards.data() + 1);
        }
    }
    const double depth = nearest - from[2];
    const double across = surface == seed + 50 ? nearest : from[1] + ray[1] * depth;
    // Near boards get textures as fine in the picture as far ones.
    return texture((from[0] + ray[0] * depth) * 3 / nearest, across * 3 / nearest, surface);
}

Image render(const TurnedCameras& cameras, double side) {
    const bool is_right = side > 0;
    const int width = cameras.width, height = cameras.height;
    Image image{width, height, 1, {}};
    const double focal = cameras.focal_px * (is_right ? cameras.right_focal : 1);
    const Vector from = is_right ? Vector{cameras.baseline, 0, cameras.forward} : Vector{};
    const double half_diagonal2 = (1.0 * width * width + 1.0 * height * height) / 4;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double bent_x = x + 0.5 - width / 2.0, bent_y = y + 0.5 - height / 2.0;
            const double straighten =
                (1 + cameras.radial * (bent_x * bent_x + bent_y * bent_y) / half_diagonal2) / focal;
            Vector ray = {bent_x * straighten, bent_y * straighten, 1};
            ray = turned_about(2, cameras.common_roll + side * cameras.roll / 2, ray);
            ray = turned_about(1, cameras.common_yaw + side * cameras.yaw / 2, ray);
            ray = turned_about(0, side * cameras.pitch / 2, ray);
            const double value = light(from, {ray[0] / ray[2], ray[1] / ray[2], 1}, cameras.seed);
            image.pixels.push_back(static_cast<std::uint8_t>(20 + 215 * value + 0.5));
        }
    return image;
}

}  // namespace

StereoPair render_pair(const TurnedCameras& cameras) {
    return {render(cameras, -1), render(cameras, 1)};
}

}  // namespace hexrelief::alignment
