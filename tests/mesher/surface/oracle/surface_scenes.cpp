#include "surface_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace hexrelief::surface::oracle {
namespace {

class Random {
  public:
    explicit Random(int seed) : state_(static_cast<std::uint64_t>(seed) * 2654435761u + 12345) {
        for (int i = 0; i < 4; ++i) whole(2);
    }
    // Returns an integer from 0 .. count - 1.
    int whole(int count) {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return static_cast<int>((state_ >> 33) % static_cast<std::uint64_t>(count));
    }
    double between(double low, double high) { return low + (high - low) * whole(1 << 20) / (1 << 20); }
    bool one_in(int count) { return whole(count) == 0; }

  private:
    std::uint64_t state_;
};

double length(double x, double y) {
    return std::sqrt(x * x + y * y);
}

struct Plane {
    double d, gx, gy;
    double at(double x, double y) const { return d + gx * x + gy * y; }
};

Plane any_plane(Random& random) {
    Plane plane{random.between(6, 45), 0, 0};
    if (random.one_in(2)) plane.gx = random.between(-0.6, 0.6), plane.gy = random.between(-0.6, 0.6);
    if (random.one_in(6)) plane.gy = random.between(-3, 3);  // a floor seen at a grazing angle
    return plane;
}

// covers(x, y) of a layer.
using Shape = std::function<bool(double, double)>;

Shape any_shape(const Scene& scene, Random& random, std::string& name) {
    const double w = scene.map.width, h = scene.map.height;
    const double x0 = random.between(0, w), y0 = random.between(0, h), size = random.between(2, 0.4 * w);
    const double nx = random.between(-1, 1), ny = random.between(-1, 1), narrow = random.between(0.5, 3);
    switch (random.whole(6)) {
        case 0:
            name += " disc";
            return [=](double x, double y) { return length(x - x0, y - y0) < size; };
        case 1:
            name += " step-across";
            return [=](double x, double) { return (nx > 0) == (x > x0); };
        case 2:
            name += " step-down";
            return [=](double, double y) { return (nx > 0) == (y > y0); };
        case 3:
            name += " half-plane";
            return [=](double x, double y) { return (x - x0) * nx + (y - y0) * ny > 0; };
        case 4:
            name += " bar";
            return [=](double x, double y) {
                return std::fabs((x - x0) * nx + (y - y0) * ny) < narrow * length(nx, ny);
            };
        default:
            name += " box";
            return [=](double x, double y) {
                return std::fabs(x - x0) < size && std::fabs(y - y0) < 0.6 * size;
            };
    }
}

void paint(const Shape& shape, const std::function<double(double, double)>& value, DisparityMap& map) {
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (shape(x + 0.5, y + 0.5)) map.at(x, y) = static_cast<float>(value(x + 0.5, y + 0.5));
}

// Adds a surface, a low step on the surfaces below it, a hole, or background.
void add_layer(Random& random, Scene& scene) {
    DisparityMap& map = scene.map;
    const Shape shape = any_shape(scene, random, scene.name);
    const Plane plane = any_plane(random);
    const double height = random.between(1.5, 6), low = random.one_in(2) ? height : -height;
    const float unknown = random.one_in(2) ? 0 : kUnknownDisparity;
    switch (random.whole(8)) {
        case 0:
            scene.name += "=hole";
            return paint(
                shape, [=](double, double) { return unknown; }, map);
        case 1:
            scene.name += "=background";
            return paint(
                shape, [](double, double) { return 1.5; }, map);
        case 2:
        case 3:
        case 4: {
            scene.name += "=low";
            const DisparityMap before = map;
            return paint(
                shape,
                [&](double x, double y) { return before.at(static_cast<int>(x), static_cast<int>(y)) + low; },
                map);
        }
        default:
            return paint(
                shape, [=](double x, double y) { return plane.at(x, y); }, map);
    }
}

void add_noise(Random& random, DisparityMap& map) {
    if (random.one_in(3)) {
        const double size = random.between(0.1, 1.2);
        for (float& d : map.values) d += static_cast<float>(random.between(-size, size));
    }
    if (random.one_in(3))
        for (int k = random.whole(40); k > 0; --k) {
            const int x = random.whole(map.width), y = random.whole(map.height), size = 1 + random.whole(3);
            const float off = static_cast<float>(random.between(-15, 25));
            const bool hole = random.one_in(4);
            for (int v = y; v < std::min(y + size, map.height); ++v)
                for (int u = x; u < std::min(x + size, map.width); ++u)
                    map.at(u, v) = hole ? kUnknownDisparity : map.at(u, v) + off;
        }
}

void quantize(Random& random, DisparityMap& map) {
    const int parts = std::array{0, 1, 4, 16}[random.whole(4)];
    for (float& d : map.values) {
        if (!std::isfinite(d)) continue;
        if (parts > 0) d = std::floor(d * static_cast<float>(parts) + 0.5f) / static_cast<float>(parts);
        d = std::max(d, 0.0f);
    }
}

double least_area2(const HexMesh2D& lattice) {
    double least = 1e9;
    for (int row = 0; row + 1 < lattice.rows; ++row)
        for (int column = 0; column + 1 < lattice.columns; ++column)
            for (const Triangle& t : quad_triangles(lattice.columns, column, row)) {
                const Vec2f &a = lattice.positions[t[0]], &b = lattice.positions[t[1]],
                            &c = lattice.positions[t[2]];
                least = std::min(least, (double(b.x) - a.x) * (double(c.y) - a.y) -
                                            (double(b.y) - a.y) * (double(c.x) - a.x));
            }
    return least;
}

// Returns a lattice over the rectangle from (x0, y0) to (x1, y1) with columns at least `wide` and rows at
// least `high` apart; its vertices are displaced by up to `jitter` of that, those of the border along it, and
// crowded on one side by `crowding`, -1 .. 1.
HexMesh2D lattice_over(Random random, double x0, double y0, double x1, double y1, double wide, double high,
                       double jitter, double crowding = 0) {
    HexMesh2D lattice;
    // maps 0 .. 1 to 0 .. 1
    const auto crowded = [=](double share) { return share + crowding * share * (1 - share); };
    lattice.columns = std::max(2, static_cast<int>((x1 - x0) / wide) + 1);
    lattice.rows = std::max(2, static_cast<int>((y1 - y0) / high) + 1);
    wide = (x1 - x0) / (lattice.columns - 1);
    high = (y1 - y0) / (lattice.rows - 1);
    for (int row = 0; row < lattice.rows; ++row)
        for (int column = 0; column < lattice.columns; ++column) {
            const double across = column + 0.5 * (row % 2) + random.between(-jitter, jitter),
                         down = row + random.between(-jitter, jitter);
            double x = x0 + (x1 - x0) * crowded(across * wide / (x1 - x0)),
                   y = y0 + (y1 - y0) * crowded(down * high / (y1 - y0));
            if (column == 0 || x < x0) x = x0;
            if (column + 1 == lattice.columns || x > x1) x = x1;
            if (row == 0) y = y0;
            if (row + 1 == lattice.rows) y = y1;
            if ((column == 0 || column + 1 == lattice.columns) && (row == 0 || row + 1 == lattice.rows))
                x = column == 0 ? x0 : x1;
            lattice.positions.push_back({static_cast<float>(x), static_cast<float>(y)});
        }
    return lattice;
}

// Returns a lattice in whole or half pixels, so that many edges cross silhouettes at equal shares.
HexMesh2D even_lattice(Random random, const DisparityMap& map) {
    const int spacing = 4 + random.whole(6), rise = 4 + random.whole(4);
    return lattice_over(random, 0, 0, map.width / spacing * spacing, map.height / rise * rise, spacing, rise,
                        0);
}

HexMesh2D any_lattice(Random& random, const DisparityMap& map) {
    if (random.one_in(6)) return even_lattice(random, map);
    const double spacing = random.one_in(6) ? random.between(10, 18) : random.between(4, 9);
    const double margin = random.one_in(5) ? random.between(1, 5) : 0,
                 crowding = random.one_in(3) ? random.between(-0.8, 0.8) : 0;
    for (double jitter = random.one_in(4) ? 0 : random.between(0, 0.3);; jitter /= 2) {
        HexMesh2D lattice = lattice_over(random, margin, margin, map.width - margin, map.height - margin,
                                         spacing, 0.866 * spacing, jitter, crowding);
        if (least_area2(lattice) > 0.5 || jitter < 1e-3) return lattice;
    }
}

}  // namespace

Scene make_scene(int number) {
    Random random(number);
    Scene scene;
    scene.name = "scene " + std::to_string(number) + ":";
    scene.map.width = 24 + random.whole(67);
    scene.map.height = 20 + random.whole(51);
    scene.map.values.resize(static_cast<std::size_t>(scene.map.width) * scene.map.height);
    const Plane plane = any_plane(random);
    paint([](double, double) { return true; }, [&](double x, double y) { return plane.at(x, y); }, scene.map);
    for (int layers = random.whole(6); layers > 0; --layers) add_layer(random, scene);
    add_noise(random, scene.map);
    quantize(random, scene.map);
    scene.lattice = any_lattice(random, scene.map);
    scene.background_px = random.one_in(2) ? 3.0f : 0.0f;
    scene.config.bridge = random.one_in(5);
    scene.config.least_discontinuity_px = random.one_in(4) ? 2 : 0;
    scene.config.split_rounds = 1 + random.whole(4);
    scene.config.inset_px = random.one_in(2) ? 0.3 : 0;
    return scene;
}

}  // namespace hexrelief::surface::oracle
