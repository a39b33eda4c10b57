#include "matching_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hexrelief::matching::oracle {
namespace {

struct Surface {
    double d = 0, gx = 0, gy = 0;
    double at(int x, int y) const { return std::max(0.0, d + gx * x + gy * y); }
};

// Returns the disparities of a plane and of boxes in front of it.
std::vector<double> any_surfaces(int width, int height, double most, Random& random) {
    const auto any = [&](double gradient) {
        return Surface{most * random.whole(101) / 100, gradient * random.between(-100, 100) / 100,
                       gradient * random.between(-100, 100) / 100};
    };
    const Surface behind = any(random.one_in(2) ? 0.0 : 0.3);
    std::vector<double> map;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) map.push_back(std::min(most, behind.at(x, y)));
    for (int boxes = random.whole(4); boxes > 0; --boxes) {
        const Surface surface = any(random.one_in(2) ? 0.0 : 0.5);
        const int x0 = random.whole(width), x1 = x0 + random.between(1, width);
        const int y0 = random.whole(height), y1 = y0 + random.between(1, height);
        for (int y = y0; y < std::min(y1, height); ++y)
            for (int x = x0; x < std::min(x1, width); ++x)
                map[static_cast<std::size_t>(y) * width + x] = std::min(most, surface.at(x - x0, y - y0));
    }
    return map;
}

// Returns a random texture: few levels give ties, equal neighbours give smooth pictures.
Image any_texture(int width, int height, int channels, Random& random) {
    Image image = make_noise(width, height, channels, random);
    const int levels = random.any_of<int>({1, 2, 4, 40, 256, 256}), alike = random.any_of<int>({1, 1, 2, 5});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c) {
                const int from = image.at(x / alike * alike, y / alike * alike)[c];
                image.at(x, y)[c] = static_cast<std::uint8_t>(from * levels / 256 * (255 / levels));
            }
    return image;
}

// Returns the right view: each pixel shows the nearest surface that is projected to it;
// the others show noise.
Image right_view(const Image& left, const std::vector<double>& map, int min_px, Random& random) {
    Image right = make_noise(left.width, left.height, left.channels, random);
    std::vector<double> nearest(map.size(), -1);
    for (int y = 0; y < left.height; ++y)
        for (int x = 0; x < left.width; ++x) {
            const double d = map[static_cast<std::size_t>(y) * left.width + x];
            const int xr = x - min_px - static_cast<int>(std::lround(d));
            if (xr < 0 || xr >= left.width) continue;
            double& there = nearest[static_cast<std::size_t>(y) * left.width + xr];
            if (d <= there) continue;
            there = d;
            std::copy_n(left.at(x, y), left.channels, right.at(xr, y));
        }
    return right;
}

void add_noise(Image& image, int most, Random& random) {
    for (std::uint8_t& value : image.pixels)
        value = static_cast<std::uint8_t>(std::clamp(value + random.between(-most, most), 0, 255));
}

// Returns the picture with the other number of channels: the grey one three times, or the first one of three.
Image with_other_channels(const Image& image) {
    Image other{image.width, image.height, 4 - image.channels, {}};
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            other.pixels.insert(other.pixels.end(), static_cast<std::size_t>(other.channels),
                                *image.at(x, y));
    return other;
}

Settings any_settings(Random& random) {
    Settings settings{.min_px = random.any_of<int>({0, 0, -7, -3, 2, 9}),
                      .count = random.any_of<int>({1, 2, 3, 5, 16, 16, 40, 64})};
    if (random.one_in(2)) {
        settings.p1 = random.any_of<int>({1, 10, 100, 15999});
        settings.p2 = std::min(16000, settings.p1 + random.any_of<int>({1, 7, 200, 15000}));
    }
    if (random.one_in(2)) settings.limit = random.any_of<int>({-1, 0, 1, 16, 40});
    settings.speckle_pixels = random.any_of<int>({0, 1, 5, 20, 100});
    settings.speckle_step = random.any_of<int>({0, 8, 32, 100});
    settings.least = random.any_of<int>({0, 0, 0, 1, 37, 200});
    return settings;
}

// Sets a range of more disparities than are searched at a pixel; mostly on both sides of 0, so that surfaces
// far apart are in both views.
void set_wide_range(Settings& settings, Random& random) {
    settings.count = random.any_of<int>({65, 72, 101, 128, 130, 150, 171, 200, 257, 300, 1920});
    if (!random.one_in(4)) settings.min_px = -settings.count / 2 + random.between(-9, 9);
}

}  // namespace

Image make_noise(int width, int height, int channels, Random& random) {
    Image image{width, height, channels, {}};
    for (int i = 0; i < width * height * channels; ++i)
        image.pixels.push_back(static_cast<std::uint8_t>(random.whole(256)));
    return image;
}

bool is_wide(int number) {
    return number % 4 == 3;
}

Scene make_scene(int number) {
    // The widths of the last two end a block of 32 and one of 256 pixels with a partial one.
    static const std::vector<std::array<int, 2>> sizes = {{16, 1}, {17, 9},  {61, 43}, {1, 1},  {1, 12},
                                                          {5, 30}, {40, 25}, {33, 33}, {65, 8}, {261, 5}};
    Random random(number);
    static const std::vector<std::array<int, 2>> wide_sizes = {{190, 12}, {151, 17}, {97, 31}, {230, 3}};
    const auto [width, height] =
        is_wide(number) ? random.any_of(wide_sizes) : sizes[static_cast<std::size_t>(number) % sizes.size()];
    Scene scene{"scene " + std::to_string(number), {}, any_settings(random)};
    if (is_wide(number)) set_wide_range(scene.settings, random);
    const int channels = random.one_in(2) ? 1 : 3;
    const std::vector<double> map = any_surfaces(width, height, scene.settings.count - 1, random);
    scene.pair.left = any_texture(width, height, channels, random);
    scene.pair.right = right_view(scene.pair.left, map, scene.settings.min_px, random);
    const int noise = random.any_of<int>({0, 0, 3, 20});
    add_noise(scene.pair.left, noise, random);
    add_noise(scene.pair.right, noise, random);
    if (random.one_in(5)) scene.pair.right = with_other_channels(scene.pair.right);
    return scene;
}

Grid make_map(int width, int height, int most, Random& random) {
    const std::vector<double> surfaces = any_surfaces(width, height, most, random);
    Grid map(width, height, 0);
    const int lump = random.any_of<int>({0, 2, 8, 40}), unknown = random.any_of<int>({2, 10, 1000});
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const int d = static_cast<int>(surfaces[i]) + (random.one_in(3) ? random.between(-lump, lump) : 0);
        map.values[i] = random.one_in(unknown) ? kUnknown : std::clamp(d, 0, most);
    }
    return map;
}

}  // namespace hexrelief::matching::oracle
