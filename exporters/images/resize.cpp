#include "exporters/images/resize.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace hexrelief::exporters {
namespace {

// The pixels of a row of `from` px that one pixel of a row of `to` px covers, with their shares.
struct Cover {
    int first = 0;
    std::vector<double> shares;
};

std::vector<Cover> covers(int from, int to) {
    std::vector<Cover> out(to);
    const double scale = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i) {
        const double begin = i * scale, end = std::min<double>(from, (i + 1) * scale);
        out[i].first = static_cast<int>(begin);
        for (int p = out[i].first; p < end; ++p)
            out[i].shares.push_back((std::min<double>(p + 1, end) - std::max<double>(p, begin)) /
                                    (end - begin));
    }
    return out;
}

}  // namespace

Image resized(const Image& image, int width, int height) {
    const auto channels = static_cast<std::size_t>(image.channels);
    Image out{width, height, image.channels, {}};
    out.pixels.reserve(static_cast<std::size_t>(width) * height * channels);
    const std::vector<Cover> columns = covers(image.width, width), rows = covers(image.height, height);
    std::vector<double> sums(static_cast<std::size_t>(width) * channels);
    for (const Cover& row : rows) {
        std::fill(sums.begin(), sums.end(), 0.0);
        int y = row.first;
        for (const double share : row.shares) {
            const std::uint8_t* const line = image.at(0, y++);
            double* sum = sums.data();
            for (const Cover& column : columns) {
                const std::uint8_t* const first = line + static_cast<std::size_t>(column.first) * channels;
                for (std::size_t channel = 0; channel < channels; ++channel) {
                    const std::uint8_t* value = first + channel;
                    double across = 0;
                    for (const double part : column.shares) {
                        across += part * *value;
                        value += channels;
                    }
                    *sum++ += share * across;
                }
            }
        }
        for (const double sum : sums) out.pixels.push_back(static_cast<std::uint8_t>(std::lround(sum)));
    }
    return out;
}

}  // namespace hexrelief::exporters
