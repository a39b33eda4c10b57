// Small vectors, with no arithmetic beyond what the data structs need.
#pragma once

namespace hexrelief {

struct Vec2f {
    float x = 0, y = 0;
    friend bool operator==(const Vec2f&, const Vec2f&) = default;
};

// A triangle is degenerate if twice its area in the image, in px^2, is below this.
inline constexpr float kDegenerateArea_px = 1e-4f;

struct Vec3f {
    float x = 0, y = 0, z = 0;
    friend bool operator==(const Vec3f&, const Vec3f&) = default;
};

}  // namespace hexrelief
