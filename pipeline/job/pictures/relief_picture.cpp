#include "pipeline/job/pictures/relief_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/job/pictures/drawing.h"

namespace hexrelief::job {
namespace {

constexpr int kLongSide_px = 1200;
constexpr int kSupersampling = 2;
constexpr float kYaw_rad = 0.349066f;    // 20 degrees
constexpr float kPitch_rad = 0.122173f;  // 7 degrees
constexpr Rgb kBackdrop = {236, 238, 241};
constexpr Rgb kClay = {200, 190, 178};

Vec3f turn(Vec3f v) {
    const float cy = std::cos(kYaw_rad), sy = std::sin(kYaw_rad), cp = std::cos(kPitch_rad),
                sp = std::sin(kPitch_rad);
    const Vec3f yawed{cy * v.x - sy * v.z, v.y, sy * v.x + cy * v.z};
    return {yawed.x, cp * yawed.y - sp * yawed.z, sp * yawed.y + cp * yawed.z};
}

// A vertex on the canvas: position in samples, 1/depth, light, texture position divided by depth.
struct Corner {
    float x = 0, y = 0, inverse_depth = 0, light = 0, u = 0, v = 0;
};

float lighting(Vec3f normal) {
    const Vec3f light{-0.40f, 0.45f, 0.80f};  // from above left, behind the camera; about unit length
    const float facing = normal.x * light.x + normal.y * light.y + normal.z * light.z;
    return 0.38f + 0.67f * std::max(0.0f, facing);
}

struct Canvas {
    Image picture;
    std::vector<float> inverse_depth;
    const Image* texture;

    void shade(int x, int y, float w, float light, float u, float v) {
        Rgb colour = kClay;
        if (texture) {
            const int tx = std::clamp(static_cast<int>(u / w * texture->width), 0, texture->width - 1);
            const int ty = std::clamp(static_cast<int>(v / w * texture->height), 0, texture->height - 1);
            const std::uint8_t* texel = texture->at(tx, ty);
            for (int c = 0; c < 3; ++c) colour[c] = texel[texture->channels == 1 ? 0 : c];
        }
        for (int c = 0; c < 3; ++c)
            picture.at(x, y)[c] =
                static_cast<std::uint8_t>(std::clamp(light * colour[c] + 0.5f, 0.0f, 255.0f));
    }

    void draw(const Corner& a, const Corner& b, const Corner& c) {
        const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if (area == 0) return;
        const int x0 = std::max(0, static_cast<int>(std::floor(std::min({a.x, b.x, c.x}))));
        const int x1 = std::min(picture.width - 1, static_cast<int>(std::ceil(std::max({a.x, b.x, c.x}))));
        const int y0 = std::max(0, static_cast<int>(std::floor(std::min({a.y, b.y, c.y}))));
        const int y1 = std::min(picture.height - 1, static_cast<int>(std::ceil(std::max({a.y, b.y, c.y}))));
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) {
                const float px = x + 0.5f, py = y + 0.5f;
                const float l0 = ((b.x - px) * (c.y - py) - (c.x - px) * (b.y - py)) / area;
                const float l1 = ((c.x - px) * (a.y - py) - (a.x - px) * (c.y - py)) / area;
                const float l2 = 1 - l0 - l1;
                if (l0 < 0 || l1 < 0 || l2 < 0) continue;
                const float w = l0 * a.inverse_depth + l1 * b.inverse_depth + l2 * c.inverse_depth;
                float& nearest = inverse_depth[static_cast<std::size_t>(y) * picture.width + x];
                if (w <= nearest) continue;
                nearest = w;
                shade(x, y, w, l0 * a.light + l1 * b.light + l2 * c.light, l0 * a.u + l1 * b.u + l2 * c.u,
                      l0 * a.v + l1 * b.v + l2 * c.v);
            }
        }
    }
};

float median_depth(const SurfaceMesh& mesh) {
    std::vector<float> depths;
    depths.reserve(mesh.positions.size());
    for (const Vec3f& p : mesh.positions) depths.push_back(-p.z);
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return *middle;
}

}  // namespace

Image render_relief(const SurfaceMesh& mesh, const Image* texture) {
    if (mesh.empty()) return blank_picture(kLongSide_px, kLongSide_px * 3 / 4, kBackdrop);
    // The camera turns about the point at the median depth on its axis, and steps back a little.
    const float pivot = median_depth(mesh);
    std::vector<Corner> corners(mesh.positions.size());
    float left = std::numeric_limits<float>::max(), top = left, right = -left, bottom = -left;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3f p = mesh.positions[i];
        const Vec3f seen = turn({p.x, p.y, p.z + pivot});
        const float depth = std::max(0.05f * pivot, 1.15f * pivot - seen.z);
        Corner& corner = corners[i];
        corner.x = seen.x / depth;
        corner.y = -seen.y / depth;
        corner.inverse_depth = pivot / depth;
        corner.light = mesh.normals.size() == corners.size() ? lighting(mesh.normals[i]) : 1.0f;
        if (texture && mesh.texcoords.size() == corners.size()) {
            corner.u = mesh.texcoords[i].x * corner.inverse_depth;
            corner.v = mesh.texcoords[i].y * corner.inverse_depth;
        }
        left = std::min(left, corner.x);
        right = std::max(right, corner.x);
        top = std::min(top, corner.y);
        bottom = std::max(bottom, corner.y);
    }
    const float wide = std::max(right - left, 1e-6f), high = std::max(bottom - top, 1e-6f);
    const float inner = 0.94f * kLongSide_px * kSupersampling;
    const float scale = inner / std::max(wide, high);
    const float margin = 0.03f * kLongSide_px * kSupersampling;
    const auto side = [&](float extent) {
        return std::max(16, static_cast<int>((extent * scale + 2 * margin) / kSupersampling)) *
               kSupersampling;
    };
    Canvas canvas{blank_picture(side(wide), side(high), kBackdrop), {}, texture};
    canvas.inverse_depth.assign(static_cast<std::size_t>(canvas.picture.width) * canvas.picture.height, 0.0f);
    for (Corner& corner : corners) {
        corner.x = (corner.x - left) * scale + margin;
        corner.y = (corner.y - top) * scale + margin;
    }
    for (const Triangle& t : mesh.triangles) canvas.draw(corners[t[0]], corners[t[1]], corners[t[2]]);
    return shrink(canvas.picture, kSupersampling);
}

}  // namespace hexrelief::job
