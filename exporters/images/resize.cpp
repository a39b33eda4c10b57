#include "exporters/images/resize.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/thread_pool.h"

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

Image resized(const Image& image, int width, int height, int threads) {
    const auto channels = static_cast<std::size_t>(image.channels);
    const std::size_t samples = static_cast<std::size_t>(width) * channels;
    Image out{width, height, image.channels, {}};
    out.pixels.resize(samples * static_cast<std::size_t>(height));
    const std::vector<Cover> columns = covers(image.width, width), rows = covers(image.height, height);
    ThreadPool(threads).parallel_for(rows.size(), [&](std::size_t first_row, std::size_t last_row) {
        std::vector<double> sums(samples);
        for (std::size_t row = first_row; row < last_row; ++row) {
            std::fill(sums.begin(), sums.end(), 0.0);
            int y = rows[row].first;
            for (const double share : rows[row].shares) {
                const std::uint8_t* const line = image.at(0, y++);
                double* sum = sums.data();
                for (const Cover& column : columns) {
                    const std::uint8_t* const first =
                        line + static_cast<std::size_t>(column.first) * channels;
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
            std::ranges::transform(sums, &out.pixels[row * samples],
                                   [](double sum) { return static_cast<std::uint8_t>(std::lround(sum)); });
        }
    });
    return out;
}

}  // namespace hexrelief::exporters
