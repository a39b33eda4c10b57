// Small vectors; no arithmetic beyond what the data structs need.
#pragma once

namespace hexrelief {

struct Vec2f {
    float x = 0, y = 0;
    friend bool operator==(const Vec2f&, const Vec2f&) = default;
};

// Twice a triangle's area in the image, px^2: one with less is degenerate.
inline constexpr float kDegenerateArea_px = 1e-4f;

struct Vec3f {
    float x = 0, y = 0, z = 0;
    friend bool operator==(const Vec3f&, const Vec3f&) = default;
};

}  // namespace hexrelief
