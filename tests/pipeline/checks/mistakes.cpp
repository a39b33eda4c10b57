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

Image cropped(const Image& image, int width, int height) {
    Image result{width, height, image.channels, {}};
    for (int y = 0; y < height; ++y)
        result.pixels.insert(result.pixels.end(), image.at(0, y), image.at(0, y) + width * image.channels);
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
