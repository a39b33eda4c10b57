// Rotations and translations between cameras.
#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace hexrelief::readers::codec {

// x becomes rotation x + translation; the rotation is row-major.
struct Rigid {
    std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::array<double, 3> translation{};
};

inline std::array<double, 9> transposed(const std::array<double, 9>& m) {
    return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]};
}

// Returns the movement by `first`, then by `then`.
inline Rigid product(const Rigid& then, const Rigid& first) {
    Rigid both;
    const auto &a = then.rotation, &b = first.rotation;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j)
            both.rotation[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
        both.translation[i] = a[3 * i] * first.translation[0] + a[3 * i + 1] * first.translation[1] +
                              a[3 * i + 2] * first.translation[2] + then.translation[i];
    }
    return both;
}

inline Rigid inverse(const Rigid& a) {
    Rigid back{transposed(a.rotation), {}};
    const Rigid moved = product(back, {{}, a.translation});
    for (std::size_t i = 0; i < 3; ++i) back.translation[i] = -moved.translation[i];
    return back;
}

// Returns the movement of a 4x4 matrix, row-major.
inline Rigid rigid_of(const std::vector<double>& m) {
    return {{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}, {m[3], m[7], m[11]}};
}

// Returns the rotation about a vector, whose length is the angle (Rodrigues).
inline std::array<double, 9> rotation_about(double x, double y, double z) {
    const double angle = std::sqrt(x * x + y * y + z * z);
    if (angle == 0) return {1, 0, 0, 0, 1, 0, 0, 0, 1};
    x /= angle, y /= angle, z /= angle;
    const double c = std::cos(angle), s = std::sin(angle), d = 1 - c;
    return {c + d * x * x,     d * x * y - s * z, d * x * z + s * y, d * x * y + s * z, c + d * y * y,
            d * y * z - s * x, d * x * z - s * y, d * y * z + s * x, c + d * z * z};
}

}  // namespace hexrelief::readers::codec
