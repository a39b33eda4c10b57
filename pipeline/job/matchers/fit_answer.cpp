#include "pipeline/job/matchers/fit_answer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "pipeline/data/error.h"
#include "pipeline/job/maps/fit_map.h"

namespace hexrelief::job {
namespace {

constexpr int kSamples = 100;            // along each side
constexpr int kLargestDifference = 40;   // of two levels: beyond it the pixels are just different
constexpr double kClearlyBetter = 0.75;  // of the difference

int level_at(const Image& image, int x, int y) {
    const std::uint8_t* const pixel = image.at(x, y);
    int sum = 0;
    for (int c = 0; c < image.channels; ++c) sum += pixel[c];
    return sum / image.channels;
}

std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

// Returns the mean difference of a sample of pixels from those that they match, if all disparities are
// multiplied by `factor`. A match outside the picture counts as different.
double difference(const DisparityMap& map, const StereoPair& pair, double factor) {
    long long sum = 0, count = 0;
    for (int row = 0; row < kSamples; ++row)
        for (int column = 0; column < kSamples; ++column) {
            const int x = column * map.width / kSamples, y = row * map.height / kSamples;
            const float d = map.at(x, y);
            if (!DisparityMap::known(d)) continue;
            const long match = std::lround(x - factor * d);
            const bool is_inside = match >= 0 && match < map.width;
            sum += is_inside ? std::min(kLargestDifference,
                                        std::abs(level_at(pair.left, x, y) -
                                                 level_at(pair.right, static_cast<int>(match), y)))
                             : kLargestDifference;
            ++count;
        }
    return count == 0 ? kLargestDifference : static_cast<double>(sum) / static_cast<double>(count);
}

void resize(DisparityMap& map, int width, int height) {
    DisparityMap resized{width, height, {}};
    resized.values.reserve(static_cast<std::size_t>(width) * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            resized.values.push_back(
                map.at(static_cast<int>(static_cast<long long>(x) * map.width / width),
                       static_cast<int>(static_cast<long long>(y) * map.height / height)));
    map = std::move(resized);
}

}  // namespace

std::string fit_answer(DisparityMap& map, const StereoPair& pair) {
    const int width = pair.left.width, height = pair.left.height;
    std::string told = fit_to_picture(map, width, height);
    const double by = static_cast<double>(width) / map.width;
    if (std::abs(by * map.height - height) > by + 1)
        throw Error(ErrorKind::input, "the map is " + size_text(map.width, map.height) +
                                          ", the pictures are " + size_text(width, height) +
                                          ": their shapes differ");
    if (map.width != width || map.height != height) {
        told += (told.empty() ? "" : "; ") +
                ("the map's " + size_text(map.width, map.height) + " px are brought to ") +
                size_text(width, height);
        resize(map, width, height);
    }
    // The likeliest first: the disparities are in px of the map, with the sign of the left view.
    const std::array<double, 4> factors{by, 1, -by, -1};
    double best = factors[0], least = difference(map, pair, best);
    for (const double factor : factors)
        if (const double other = difference(map, pair, factor); other < kClearlyBetter * least)
            best = factor, least = other;
    if (best == 1) return told;
    for (float& d : map.values)
        if (DisparityMap::known(d)) d = static_cast<float>(d * best);
    if (best < 0)
        told += std::string(told.empty() ? "" : "; ") + "its disparities have the other sign, and are turned";
    return told;
}

}  // namespace hexrelief::job
