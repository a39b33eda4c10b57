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
    Image out{width, height, image.channels, {}};
    out.pixels.reserve(static_cast<std::size_t>(width) * height * image.channels);
    const std::vector<Cover> columns = covers(image.width, width), rows = covers(image.height, height);
    for (const Cover& row : rows) {
        for (const Cover& column : columns) {
            for (int channel = 0; channel < image.channels; ++channel) {
                double sum = 0;
                for (std::size_t y = 0; y < row.shares.size(); ++y) {
                    double line = 0;
                    for (std::size_t x = 0; x < column.shares.size(); ++x)
                        line += column.shares[x] * image.at(column.first + static_cast<int>(x),
                                                            row.first + static_cast<int>(y))[channel];
                    sum += row.shares[y] * line;
                }
                out.pixels.push_back(static_cast<std::uint8_t>(std::lround(sum)));
            }
        }
    }
    return out;
}

}  // namespace hexrelief::exporters
