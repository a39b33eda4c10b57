#include "pipeline/job/pictures/stage_pictures.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "exporters/images/image_writer.h"
#include "mesher/mesher.h"
#include "pipeline/data/number_text.h"
#include "pipeline/data/shrink.h"
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
        for (int y = y0; y <= y1; ++y)
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
};

float median_depth(const SurfaceMesh& mesh) {
    std::vector<float> depths;
    depths.reserve(mesh.positions.size());
    for (const Vec3f& p : mesh.positions) depths.push_back(-p.z);
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::ranges::nth_element(depths, middle);
    return *middle;
}

constexpr int kSamples = 10000;
constexpr int kSmallSide_px = 900;  // narrower pictures are drawn twice as large

int scale_of(int width) {
    return width < kSmallSide_px ? 2 : 1;
}

// Returns a colour of the map. Lightness rises evenly along the anchors; the hue goes from blue over green to
// yellow, which the colour-blind can distinguish.
Rgb heat_colour(float share) {
    static constexpr float anchors[7][3] = {{24, 18, 77},   {33, 62, 128},  {25, 104, 140}, {26, 145, 136},
                                            {72, 182, 107}, {157, 212, 66}, {250, 230, 70}};
    const float at = std::clamp(share, 0.0f, 1.0f) * 6;
    const int low = std::min(5, static_cast<int>(at));
    Rgb colour{};
    for (int c = 0; c < 3; ++c)
        colour[c] = static_cast<std::uint8_t>(
            std::lround(anchors[low][c] + (at - low) * (anchors[low + 1][c] - anchors[low][c])));
    return colour;
}

// Returns a number uniform in [0, 1) that depends only on its arguments: draw `draw` of sample `index`.
double uniform(std::uint64_t seed, std::uint64_t index, std::uint64_t draw) {
    std::uint64_t x =
        seed * 0x9e3779b97f4a7c15ull + index * 0xd1b54a32d192ed03ull + draw * 0x8cb92ba72f3d8dd7ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    x ^= x >> 31;
    return static_cast<double>(x >> 11) * 0x1.0p-53;
}

void append_number(std::string& text, float value) {
    char buffer[32];
    text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

// Returns depths in the camera's unit; infinity where they are unknown.
std::vector<float> depths_of(const DisparityMap& map, const Calibration& camera) {
    std::vector<float> depths(map.values.size(), std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double from_infinity_px = map.values[i] + camera.doffs_px;
        if (DisparityMap::known(map.values[i]) && from_infinity_px > 0)
            depths[i] = static_cast<float>(camera.focal_px * camera.baseline_m / from_infinity_px);
    }
    return depths;
}

Image samples_picture(const DensityMap& density, std::uint64_t seed) {
    const int scale = scale_of(density.width);
    Image picture = blank_picture(density.width * scale, density.height * scale, {255, 255, 255});
    for (const Vec2f& point : sample_points(density, kSamples, seed))
        draw_disc(picture, {point.x * scale, point.y * scale}, {0, 0, 0}, 0.9f, 1.0f);
    return picture;
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
    return shrunk(canvas.picture, kSupersampling);
}

Image disparity_picture(const DisparityMap& map) {
    const auto [least, largest] = known_range(map);
    const float span = largest > least ? largest - least : 1.0f;
    Image picture = blank_picture(map.width, map.height, {0, 0, 0});
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        if (!DisparityMap::known(map.values[i])) continue;
        const Rgb colour = heat_colour((map.values[i] - least) / span);
        std::copy(colour.begin(), colour.end(), picture.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
    return picture;
}

Image density_picture(const DensityMap& density) {
    Image picture{density.width, density.height, 1, {}};
    picture.pixels.resize(density.values.size());
    const float largest = density.values.empty() ? 0 : *std::ranges::max_element(density.values);
    for (std::size_t i = 0; i < density.values.size() && largest > 0; ++i)
        picture.pixels[i] =
            static_cast<std::uint8_t>(std::lround(255 * std::pow(density.values[i] / largest, 1 / 2.2f)));
    return picture;
}

std::vector<Vec2f> sample_points(const DensityMap& density, int count, std::uint64_t seed) {
    std::vector<double> sums(density.values.size());
    double total = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = total += density.values[i];
    std::vector<Vec2f> points;
    if (!(total > 0)) return points;
    points.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        const auto slot = std::upper_bound(sums.begin(), sums.end(), uniform(seed, i, 0) * total);
        const auto pixel = static_cast<int>(std::min(slot, sums.end() - 1) - sums.begin());
        const int x = pixel % density.width, y = pixel / density.width;
        points.push_back(
            {static_cast<float>(x + uniform(seed, i, 1)), static_cast<float>(y + uniform(seed, i, 2))});
    }
    return points;
}

Image mesh_picture(const HexMesh2D& mesh, const Image& backdrop) {
    const int scale = scale_of(backdrop.width);
    Image picture = enlarge_to_rgb(backdrop, scale);
    for (std::uint8_t& sample : picture.pixels)
        sample = static_cast<std::uint8_t>(sample * 7 / 10);  // darkened, so that the lines stand out
    const auto edge = [&](int c0, int r0, int c1, int r1) {
        if (c1 < 0 || c1 >= mesh.columns || r1 >= mesh.rows) return;
        const Vec2f a = mesh.at(c0, r0), b = mesh.at(c1, r1);
        const float s = static_cast<float>(scale);
        draw_segment(picture, {a.x * s, a.y * s}, {b.x * s, b.y * s}, {255, 214, 64}, 1.0f, 0.85f);
    };
    for (int row = 0; row < mesh.rows; ++row) {
        const int shift = row & 1;  // odd rows are half a spacing to the right
        for (int column = 0; column < mesh.columns; ++column) {
            edge(column, row, column + 1, row);
            edge(column, row, column - 1 + shift, row + 1);
            edge(column, row, column + shift, row + 1);
        }
    }
    return picture;
}

std::string mesh_obj(const HexMesh2D& mesh) {
    std::string text = "# lattice " + size_text(mesh.columns, mesh.rows, " x ") +
                       ", row-major, px of the left image, x right, y down\n";
    text.reserve(text.size() + mesh.positions.size() * 56);
    for (const Vec2f& p : mesh.positions) {
        text += "v ";
        append_number(text, p.x);
        text += ' ';
        append_number(text, p.y);
        text += " 0\n";
    }
    for (int row = 0; row + 1 < mesh.rows; ++row)
        for (int column = 0; column + 1 < mesh.columns; ++column)
            for (const Triangle& t : quad_triangles(mesh.columns, column, row))
                text += "f " + std::to_string(t[0] + 1) + ' ' + std::to_string(t[1] + 1) + ' ' +
                        std::to_string(t[2] + 1) + '\n';
    return text;
}

const std::vector<std::filesystem::path>& stage_file_names() {
    static const std::vector<std::filesystem::path> names = {
        "disparity.pfm", "disparity.png", "depth.exr",  "density.pfm", "density.png",
        "samples.png",   "mesh2d.obj",    "mesh2d.png", "weights.png", "relief.png"};
    return names;
}

std::vector<std::uint8_t> encode_stage_file(const StageResults& results, const std::filesystem::path& name) {
    const DisparityMap& map = *results.map;
    const DensityMap& density = *results.density;
    if (name == "disparity.pfm") return exporters::encode_pfm(map.width, map.height, map.values);
    if (name == "disparity.png") return exporters::encode_png(disparity_picture(map));
    if (name == "depth.exr")
        return exporters::encode_exr(map.width, map.height, depths_of(map, *results.camera));
    if (name == "density.pfm") return exporters::encode_pfm(density.width, density.height, density.values);
    if (name == "density.png") return exporters::encode_png(density_picture(density));
    if (name == "samples.png") return exporters::encode_png(samples_picture(density, results.seed));
    if (name == "mesh2d.png")
        return exporters::encode_png(
            mesh_picture(*results.mesh, results.left ? *results.left : disparity_picture(map)));
    if (name == "weights.png")
        return exporters::encode_png(
            weights_picture(quality::honeycomb_weights(*results.mesh, density, results.threads)));
    if (name == "relief.png") return exporters::encode_png(render_relief(*results.surface, results.texture));
    if (name != "mesh2d.obj") throw std::logic_error("no stage writes " + name.string());
    const std::string text = mesh_obj(*results.mesh);
    return {text.begin(), text.end()};
}

}  // namespace hexrelief::job
