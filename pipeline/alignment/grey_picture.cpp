#include "pipeline/alignment/grey_picture.h"

#include <algorithm>

namespace hexrelief::alignment {
namespace {

// One pixel of a reduced row or column: the source pixels that it covers, and how much of them. Lengths are
// in 1/target of a source pixel, so that all of them are whole.
struct Cover {
    int first = 0, last = 0;                      // source pixels
    std::uint32_t first_part = 0, last_part = 0;  // of these two; those between count `target` each
};

std::vector<Cover> covers_of(int source, int target) {
    std::vector<Cover> covers;
    for (std::int64_t i = 0; i < target; ++i) {
        const std::int64_t from = i * source, to = from + source;
        const int first = static_cast<int>(from / target), last = static_cast<int>((to - 1) / target);
        const std::int64_t first_end = std::min<std::int64_t>(to, (first + std::int64_t{1}) * target);
        covers.push_back({first, last, static_cast<std::uint32_t>(first_end - from),
                          static_cast<std::uint32_t>(to - static_cast<std::int64_t>(last) * target)});
    }
    return covers;
}

void grey_row(const Image& image, int y, std::vector<std::uint8_t>& row) {
    const std::uint8_t* p = image.at(0, y);
    if (image.channels == 1) {
        std::copy_n(p, image.width, row.begin());
        return;
    }
    for (int x = 0; x < image.width; ++x, p += image.channels)
        row[static_cast<std::size_t>(x)] = static_cast<std::uint8_t>((p[0] + 2 * p[1] + p[2] + 2) / 4);
}

// Adds `weight` times the row to the sums of its columns.
void add_row(const std::vector<std::uint8_t>& row, std::uint32_t weight, std::vector<std::uint32_t>& sums) {
    for (std::size_t x = 0; x < row.size(); ++x) sums[x] += weight * row[x];
}

// Returns the sum over a reduced pixel's columns, of which whole ones count `whole`.
std::uint64_t sum_of(const std::vector<std::uint32_t>& sums, const Cover& c, std::uint64_t whole) {
    std::uint64_t sum = std::uint64_t{c.first_part} * sums[static_cast<std::size_t>(c.first)];
    if (c.last == c.first) return sum;
    std::uint64_t between = 0;
    for (int x = c.first + 1; x < c.last; ++x) between += sums[static_cast<std::size_t>(x)];
    return sum + whole * between + std::uint64_t{c.last_part} * sums[static_cast<std::size_t>(c.last)];
}

int rounded_share(int side, int longest, int longer_side) {
    return std::max(1, (2 * side * longest + longer_side) / (2 * longer_side));
}

}  // namespace

GreyPicture reduced_grey(const Image& image, int longest, ThreadPool& pool) {
    const int longer = std::max(image.width, image.height);
    GreyPicture out{image.width, image.height, {}};
    if (longer > longest) {
        out.width = rounded_share(image.width, longest, longer);
        out.height = rounded_share(image.height, longest, longer);
    }
    out.values.resize(static_cast<std::size_t>(out.width) * out.height);
    const std::vector<Cover> columns = covers_of(image.width, out.width),
                             rows = covers_of(image.height, out.height);
    const std::uint64_t area =
        static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height);
    pool.parallel_for(rows.size(), [&](std::size_t first, std::size_t last) {
        std::vector<std::uint8_t> grey(static_cast<std::size_t>(image.width));
        std::vector<std::uint32_t> sums;  // of columns: at most 255 times the picture's height
        for (std::size_t i = first; i < last; ++i) {
            const Cover& cover = rows[i];
            sums.assign(grey.size(), 0);
            for (int y = cover.first; y <= cover.last; ++y) {
                const std::uint32_t weight = y == cover.first  ? cover.first_part
                                             : y == cover.last ? cover.last_part
                                                               : static_cast<std::uint32_t>(out.height);
                grey_row(image, y, grey);
                add_row(grey, weight, sums);
            }
            std::uint8_t* const to = out.row(static_cast<int>(i));
            for (std::size_t x = 0; x < columns.size(); ++x)
                to[x] = static_cast<std::uint8_t>(
                    (sum_of(sums, columns[x], static_cast<std::uint64_t>(out.width)) + area / 2) / area);
        }
    });
    return out;
}

GreyPicture halved(const GreyPicture& picture) {
    GreyPicture out{picture.width / 2, picture.height / 2, {}};
    out.values.resize(static_cast<std::size_t>(out.width) * out.height);
    for (int y = 0; y < out.height; ++y) {
        const std::uint8_t *const a = picture.row(2 * y), *const b = picture.row(2 * y + 1);
        std::uint8_t* const to = out.row(y);
        for (int x = 0; x < out.width; ++x)
            to[x] = static_cast<std::uint8_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2) / 4);
    }
    return out;
}

}  // namespace hexrelief::alignment
