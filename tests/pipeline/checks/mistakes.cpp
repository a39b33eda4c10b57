#include "mistakes.h"

#include <algorithm>
#include <cmath>

#include "exporters/images/image_writer.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/image_reader.h"

namespace hexrelief::checks::mistakes {
namespace {

Image same_size(const Image& image) {
    Image result = image;
    std::fill(result.pixels.begin(), result.pixels.end(), std::uint8_t{0});
    return result;
}

std::uint8_t to_sample(double value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

}  // namespace

Image as_grey(const Image& image) {
    Image grey{image.width, image.height, 1, {}};
    for (std::size_t i = 0; i < image.pixels.size(); i += static_cast<std::size_t>(image.channels)) {
        const std::uint8_t* p = image.pixels.data() + i;
        grey.pixels.push_back(image.channels == 1 ? p[0]
                                                  : to_sample(0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2]));
    }
    return grey;
}

Image as_stored(const Image& image, int quality) {
    return readers::image_of(readers::codec::decode_jpeg({"picture", exporters::encode_jpeg(image, quality)}),
                             "picture");
}

Image shifted(const Image& image, int columns, int rows) {
    Image result = same_size(image);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            std::copy_n(image.at(std::clamp(x - columns, 0, image.width - 1),
                                 std::clamp(y - rows, 0, image.height - 1)),
                        image.channels, result.at(x, y));
    return result;
}

Image rotated(const Image& image, double degrees) {
    Image result = same_size(image);
    const double angle = degrees * std::acos(-1.0) / 180, c = std::cos(angle), s = std::sin(angle);
    const double cx = 0.5 * (image.width - 1), cy = 0.5 * (image.height - 1);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const double u = std::clamp(cx + c * (x - cx) - s * (y - cy), 0.0, image.width - 1.001);
            const double v = std::clamp(cy + s * (x - cx) + c * (y - cy), 0.0, image.height - 1.001);
            const int i = static_cast<int>(u), j = static_cast<int>(v);
            for (int k = 0; k < image.channels; ++k) {
                const auto mix = [&](int row) {
                    return image.at(i, row)[k] * (1 - (u - i)) + image.at(i + 1, row)[k] * (u - i);
                };
                result.at(x, y)[k] = to_sample(mix(j) * (1 - (v - j)) + mix(j + 1) * (v - j));
            }
        }
    return result;
}

Image mirrored(const Image& image) {
    Image result = same_size(image);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            std::copy_n(image.at(image.width - 1 - x, y), image.channels, result.at(x, y));
    return result;
}

Image cropped(const Image& image, int width, int height, int x, int y) {
    Image result{width, height, image.channels, {}};
    for (int row = y; row < y + height; ++row)
        result.pixels.insert(result.pixels.end(), image.at(x, row),
                             image.at(x, row) + width * image.channels);
    return result;
}

Image exposed(const Image& image, double gamma, double gain) {
    Image result = image;
    for (std::uint8_t& v : result.pixels) v = to_sample(255 * gain * std::pow(v / 255.0, gamma));
    return result;
}

Image plain(const Image& like, int grey, int amplitude, int seed) {
    Image result = like;
    std::uint64_t state = static_cast<std::uint64_t>(seed) + 99991;
    for (std::uint8_t& v : result.pixels) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        v = to_sample(grey + static_cast<int>((state >> 33) % (2 * amplitude + 1)) - amplitude);
    }
    return result;
}

Image textured(const Image& image, int amplitude, int block) {
    Image result = image;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const auto cell = static_cast<std::uint32_t>(y / block * 4099 + x / block);
            const int added = static_cast<int>((cell * 2654435761u ^ (cell * 40503u) << 9) >> 24) - 128;
            for (int c = 0; c < image.channels; ++c)
                result.at(x, y)[c] = to_sample(64 + image.at(x, y)[c] / 2 + added * amplitude / 128);
        }
    return result;
}

DisparityMap filled(DisparityMap map) {
    for (int y = 0; y < map.height; ++y)
        for (int first = 0; first < map.width; ++first) {
            int end = first;
            while (end < map.width && !DisparityMap::known(map.at(end, y))) ++end;
            if (end == first) continue;
            const float left = first > 0 ? map.at(first - 1, y) : INFINITY,
                        right = end < map.width ? map.at(end, y) : INFINITY;
            const float value = std::min(left, right);
            for (int x = first; x < end; ++x) map.at(x, y) = std::isinf(value) ? 1 : value;
            first = end;
        }
    return map;
}

DisparityMap enlarged(const DisparityMap& map, int px) {
    DisparityMap rows = map, result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            for (int i = std::max(0, x - px); i <= std::min(map.width - 1, x + px); ++i)
                rows.at(x, y) = std::max(rows.at(x, y), map.at(i, y));
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            for (int i = std::max(0, y - px); i <= std::min(map.height - 1, y + px); ++i)
                result.at(x, y) = std::max(result.at(x, y), rows.at(x, i));
    return result;
}

DisparityMap blurred(const DisparityMap& map, int px) {
    DisparityMap rows = map, result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            float sum = 0;
            for (int i = x - px; i <= x + px; ++i) sum += map.at(std::clamp(i, 0, map.width - 1), y);
            rows.at(x, y) = sum / static_cast<float>(2 * px + 1);
        }
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            float sum = 0;
            for (int i = y - px; i <= y + px; ++i) sum += rows.at(x, std::clamp(i, 0, map.height - 1));
            result.at(x, y) = sum / static_cast<float>(2 * px + 1);
        }
    return result;
}

DisparityMap coarse(const DisparityMap& map, int factor) {
    const int width = map.width / factor, height = map.height / factor;
    std::vector<float> small;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            small.push_back(map.at(x * factor + factor / 2, y * factor + factor / 2));
    DisparityMap result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const double u = std::clamp((x - factor / 2) / double(factor), 0.0, width - 1.001);
            const double v = std::clamp((y - factor / 2) / double(factor), 0.0, height - 1.001);
            const int i = static_cast<int>(u), j = static_cast<int>(v);
            const auto row = [&](int k) {
                const float* const values = small.data() + static_cast<std::size_t>(k) * width;
                return values[i] * (1 - (u - i)) + values[i + 1] * (u - i);
            };
            result.at(x, y) = static_cast<float>(row(j) * (1 - (v - j)) + row(j + 1) * (v - j));
        }
    return result;
}

DisparityMap cropped(const DisparityMap& map, int x, int y, int width, int height) {
    DisparityMap result{width, height, {}};
    for (int row = y; row < y + height; ++row)
        for (int column = x; column < x + width; ++column) result.values.push_back(map.at(column, row));
    return result;
}

DisparityMap with_values(DisparityMap map, const std::function<double(double)>& value_of) {
    for (float& d : map.values)
        if (DisparityMap::known(d)) d = static_cast<float>(value_of(d));
    return map;
}

double grey_of_jet(double grey) {
    const double t = grey / 255;
    const auto ramp = [&](double center) { return std::clamp(1.5 - std::fabs(4 * t - center), 0.0, 1.0); };
    return 255 * (0.299 * ramp(3) + 0.587 * ramp(2) + 0.114 * ramp(1));
}

}  // namespace hexrelief::checks::mistakes
