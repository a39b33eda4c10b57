#include "samples/sample_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "exporters/core/file_transaction.h"
#include "exporters/images/image_writer.h"

namespace hexrelief::samples {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal_px = 320, kBaseline_m = 0.16;
constexpr int kSamples = 4;  // rays a pixel each way: the texture is finer than a pixel in the distance
constexpr int kPhotoSamples = 2;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Camera frame of the left view: x right, y down, z away, metres.
struct Vec {
    double x = 0, y = 0, z = 0;
};
Vec operator+(const Vec& a, const Vec& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Vec operator-(const Vec& a, const Vec& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vec operator*(double s, const Vec& a) {
    return {s * a.x, s * a.y, s * a.z};
}
double dot(const Vec& a, const Vec& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// A sphere (radius > 0) around `point`, or the part of the plane through `point` with the given normal whose
// points have x - lean * y within [x_from, x_to] and y within [y_from, y_to].
struct Surface {
    Vec point, normal;
    double radius = 0;
    double x_from = -kInfinity, x_to = kInfinity, y_from = -kInfinity, y_to = kInfinity, lean = 0;
    Vec colour;      // 0..1, red green blue
    double grain_m;  // longest wavelength of the texture
};

Surface upright_bar(double u_px, double z, double width_px, double lean, const Vec& colour) {
    const double x = u_px * z / kFocal_px, half = 0.5 * width_px * z / kFocal_px;
    return {.point = {0, 0, z},
            .normal = {0, 0, -1},
            .x_from = x - half,
            .x_to = x + half,
            .y_to = 0.5,
            .lean = lean,
            .colour = colour,
            .grain_m = 0.15};
}

const std::array kScene = {
    Surface{.point = {0, 0, 12}, .normal = {0.05, 0, -1}, .colour = {0.55, 0.68, 0.82}, .grain_m = 2.4},
    Surface{.point = {0, 0.55, 0}, .normal = {0.05, -1, 0}, .colour = {0.62, 0.55, 0.42}, .grain_m = 0.5},
    Surface{.point = {-1.0, 0, 2.2},
            .normal = {1, 0, 0.06},
            .y_from = -1.1,
            .colour = {0.75, 0.45, 0.35},
            .grain_m = 0.6},
    Surface{.point = {0.14, 0.22, 1.6},
            .normal = {},
            .radius = 0.31,
            .colour = {0.85, 0.62, 0.25},
            .grain_m = 0.2},
    Surface{.point = {0.85, -0.1, 3.2},
            .normal = {},
            .radius = 0.42,
            .colour = {0.4, 0.7, 0.45},
            .grain_m = 0.35},
    Surface{
        .point = {-0.42, 0.3, 2.5}, .normal = {}, .radius = 0.24, .colour = {0.5, 0.45, 0.8}, .grain_m = 0.3},
    upright_bar(-28, 2.0, 5, 0, {0.85, 0.85, 0.8}),
    upright_bar(12, 2.2, 5, 0, {0.8, 0.35, 0.4}),
    upright_bar(134, 1.9, 6, 0, {0.85, 0.85, 0.8}),
    upright_bar(30, 2.6, 5, -0.35, {0.45, 0.75, 0.75}),
};

std::uint32_t hash(std::uint32_t v) {
    v = (v ^ (v >> 16)) * 0x7feb352du;
    v = (v ^ (v >> 15)) * 0x846ca68bu;
    return v ^ (v >> 16);
}

double lattice_value(int x, int y, int z, std::uint32_t seed) {
    std::uint32_t h = hash(seed ^ static_cast<std::uint32_t>(x));
    h = hash(h ^ static_cast<std::uint32_t>(y));
    return hash(h ^ static_cast<std::uint32_t>(z)) / 4294967296.0;
}

// Value noise in space, 0..1: random values on the integer lattice, smoothly interpolated.
double value_noise(const Vec& p, std::uint32_t seed) {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double tx = smooth(p.x - fx), ty = smooth(p.y - fy), tz = smooth(p.z - fz);
    const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        sum += (i ? tx : 1 - tx) * (j ? ty : 1 - ty) * (k ? tz : 1 - tz) *
               lattice_value(x + i, y + j, z + k, seed);
    }
    return sum;
}

// The fine octaves weigh nearly as much as the coarse ones, since it is they that matching sees.
double texture(const Vec& p, double grain_m, std::uint32_t octaves, std::uint32_t seed) {
    double sum = 0, weights = 0, weight = 1, frequency = 1 / grain_m;
    for (std::uint32_t octave = 0; octave < octaves; ++octave) {
        sum += weight * (value_noise(frequency * p, hash(seed + octave)) - 0.5);
        weights += weight;
        weight *= 0.9;
        frequency *= 2;
    }
    return sum / weights;  // about -0.25..0.25
}

// Distance along the ray in units of z, or infinity.
double intersect(const Surface& s, const Vec& eye, const Vec& ray) {
    const Vec to = s.point - eye;
    if (s.radius > 0) {
        const double a = dot(ray, ray), b = dot(ray, to), c = dot(to, to) - s.radius * s.radius;
        const double root = b * b - a * c;
        return root < 0 ? kInfinity : (b - std::sqrt(root)) / a;
    }
    const double slope = dot(s.normal, ray);
    if (slope == 0) return kInfinity;
    const double t = dot(s.normal, to) / slope;
    if (!(t > 0)) return kInfinity;
    const Vec p = eye + t * ray;
    const double x = p.x - s.lean * p.y;
    return x >= s.x_from && x <= s.x_to && p.y >= s.y_from && p.y <= s.y_to ? t : kInfinity;
}

struct Hit {
    std::size_t surface = 0;
    double depth = kInfinity;
};

Hit trace(const Vec& eye, const Vec& ray) {
    Hit hit;
    for (std::size_t i = 0; i < kScene.size(); ++i) {
        const double depth = intersect(kScene[i], eye, ray);
        if (depth < hit.depth) hit = {i, depth};
    }
    return hit;
}

Vec shade(const Hit& hit, const Vec& eye, const Vec& ray) {
    const Surface& s = kScene[hit.surface];
    const Vec p = eye + hit.depth * ray;
    const Vec normal =
        s.radius > 0 ? (1 / s.radius) * (p - s.point) : (1 / std::sqrt(dot(s.normal, s.normal))) * s.normal;
    const Vec light = {-0.48, -0.64,
                       -0.6};  // towards the lamp, unit length; matt, so that both views see the same
    const double lit = 0.55 + 0.45 * std::max(0.0, dot(normal, light));
    const auto seed = static_cast<std::uint32_t>(hit.surface * 1000 + 1);
    const double grey = texture(p, s.grain_m, 6, seed);
    const double red = texture(p, s.grain_m, 2, seed + 100), blue = texture(p, s.grain_m, 2, seed + 200);
    return {lit * s.colour.x * (1 + 2.2 * grey + 0.6 * red), lit * s.colour.y * (1 + 2.2 * grey),
            lit * s.colour.z * (1 + 2.2 * grey + 0.6 * blue)};
}

Vec ray_at(double u, double v) {
    return {(u - 0.5 * kWidth) / kFocal_px, (v - 0.5 * kHeight) / kFocal_px, 1};
}

// ray(u, v): the direction that a camera at `eye` sees there.
template <typename Ray>
Image render(const Vec& eye, int width, int height, int samples, const Ray& ray_of) {
    Image image{width, height, 3, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height * 3)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            Vec sum;
            for (int i = 0; i < samples * samples; ++i) {
                const int column = i % samples, row = i / samples;
                const Vec ray = ray_of(x + (column + 0.5) / samples, y + (row + 0.5) / samples);
                sum = sum + shade(trace(eye, ray), eye, ray);
            }
            const auto byte = [&](double value) {
                const double scaled = 255 * value / (samples * samples) + 0.5;
                return static_cast<std::uint8_t>(std::clamp(scaled, 0.0, 255.0));
            };
            std::uint8_t* const pixel = image.at(x, y);
            pixel[0] = byte(sum.x);
            pixel[1] = byte(sum.y);
            pixel[2] = byte(sum.z);
        }
    return image;
}

// A photographer's camera. A turn by an angle a is given as tan(a / 2), about an axis of the camera.
struct PhotoCamera {
    Vec eye;
    double pitch, yaw, roll;
    double shift_px;  // the picture is cut out of the lens's so far to the right

    static constexpr int kColumns = 640, kRows = 480;
    static constexpr double kFocal = 620, kRadial = 0.02;  // at a corner

    static void turn(double half_tangent, double& a, double& b) {
        const double square = half_tangent * half_tangent;
        const double cosine = (1 - square) / (1 + square), sine = 2 * half_tangent / (1 + square);
        const double turned = cosine * a - sine * b;
        b = sine * a + cosine * b;
        a = turned;
    }

    Vec ray(double u, double v) const {
        const double x = u - 0.5 * kColumns + shift_px, y = v - 0.5 * kRows;
        const double corner2 = 0.25 * (kColumns * kColumns + kRows * kRows);
        const double straighten = (1 + kRadial * (x * x + y * y) / corner2) / kFocal;
        Vec ray{x * straighten, y * straighten, 1};
        turn(roll, ray.x, ray.y);
        turn(yaw, ray.z, ray.x);
        turn(pitch, ray.y, ray.z);
        return ray;
    }

    Image photograph() const {
        return render(eye, kColumns, kRows, kPhotoSamples, [this](double u, double v) { return ray(u, v); });
    }
};

// Middlebury's form: the baseline in millimetres, the principal point counted from the centre of the first
// pixel.
std::string middlebury_calibration(const SampleScene& scene) {
    const Calibration& c = scene.calibration;
    char camera[128], text[512];
    std::snprintf(camera, sizeof camera, "[%g 0 %g; 0 %g %g; 0 0 1]", c.focal_px, c.cx - 0.5, c.focal_px,
                  c.cy - 0.5);
    std::snprintf(text, sizeof text,
                  "cam0=%s\ncam1=%s\ndoffs=%g\nbaseline=%g\nwidth=%d\nheight=%d\nndisp=48\n", camera, camera,
                  c.doffs_px, 1000 * c.baseline_m, c.width, c.height);
    return text;
}

}  // namespace

StereoPair render_photographs() {
    // Rays are not scaled to z = 1: all that is asked of them is a direction.
    const PhotoCamera left{{0, 0, 0}, 0.004, 0.008, -0.007, 17.3},
        right{{kBaseline_m, 0, 0}, -0.003, -0.004, 0.005, -17.3};
    return {left.photograph(), right.photograph()};
}

SampleScene render_sample_scene() {
    const Vec left{0, 0, 0}, right{kBaseline_m, 0, 0};
    SampleScene scene;
    const auto rendered = [](const Vec& eye) { return render(eye, kWidth, kHeight, kSamples, ray_at); };
    scene.pair = {rendered(left), rendered(right)};
    scene.disparity = {kWidth, kHeight, std::vector<float>(std::size_t{kWidth} * kHeight)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double depth = trace(left, ray_at(x + 0.5, y + 0.5)).depth;
            scene.disparity.at(x, y) = static_cast<float>(kFocal_px * kBaseline_m / depth);
        }
    scene.calibration = {kFocal_px, 0.5 * kWidth, 0.5 * kHeight, kBaseline_m, 0, true, kWidth, kHeight};
    return scene;
}

std::vector<SampleFile> sample_files() {
    const SampleScene scene = render_sample_scene();
    const DisparityMap& map = scene.disparity;
    const std::string calibration = middlebury_calibration(scene);
    return {{"left.png", exporters::encode_png(scene.pair.left)},
            {"right.png", exporters::encode_png(scene.pair.right)},
            {"disparity.pfm", exporters::encode_pfm(map.width, map.height, map.values)},
            {"calib.txt", {calibration.begin(), calibration.end()}}};
}

std::vector<SampleFile> photograph_files() {
    const StereoPair pair = render_photographs();
    return {{"left.png", exporters::encode_png(pair.left)}, {"right.png", exporters::encode_png(pair.right)}};
}

void write_sample_files(const std::vector<SampleFile>& files, const std::filesystem::path& folder) {
    exporters::FileTransaction transaction;
    for (const SampleFile& file : files) transaction.write(folder / file.name, file.bytes);
    transaction.commit();
}

}  // namespace hexrelief::samples
