#include "pipeline/matching/sgm/costs.h"

#include <algorithm>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::matching {
namespace {

using Byte = std::uint8_t;

// The census of a row is stored in eight planes with a byte per pixel, so that many pixels
// are compared at once.
constexpr int kPlanes = 8;

HEXRELIEF_SMALL_VECTORS void census_row(RasterView<const Byte> grey, int y, Byte* __restrict planes) {
    const int width = grey.width;
    std::fill(planes, planes + static_cast<std::size_t>(kPlanes) * width, Byte{0});
    const Byte* __restrict centre = grey.row(y);
    int bit = 0;
    for (int j = -step::kCensusRadiusY; j <= step::kCensusRadiusY; ++j)
        for (int i = -step::kCensusRadiusX; i <= step::kCensusRadiusX; ++i) {
            if (i == 0 && j == 0) continue;
            const Byte* __restrict other = grey.row(y + j) + i;
            Byte* __restrict plane = planes + static_cast<std::size_t>(bit / 8) * width;
            const Byte mark = static_cast<Byte>(1 << bit % 8);
            for (int x = 0; x < width; ++x) plane[x] |= other[x] < centre[x] ? mark : Byte{0};
            ++bit;
        }
}

// The sum of three bits of equal weight, for each bit of a byte: a sum bit and a carry bit.
struct BitSum {
    Byte sum, carry;
};
HEXRELIEF_INLINED BitSum add_bits(Byte a, Byte b, Byte c) {
    const Byte either = a ^ b;
    return {static_cast<Byte>(either ^ c), static_cast<Byte>((a & b) | (either & c))};
}
// Returns the number of set bits in `ones` plus twice that in `twos`: at most 24.
HEXRELIEF_INLINED Byte set_bits(Byte ones, Byte twos) {
    ones = static_cast<Byte>(ones - ((ones >> 1) & 0x55));
    twos = static_cast<Byte>(twos - ((twos >> 1) & 0x55));
    ones = static_cast<Byte>((ones & 0x33) + ((ones >> 2) & 0x33));
    twos = static_cast<Byte>((twos & 0x33) + ((twos >> 2) & 0x33));
    const auto halves = static_cast<Byte>(ones + 2 * twos);
    return static_cast<Byte>((halves & 0x0f) + (halves >> 4));
}

struct CostRowView {
    const Byte *left_census, *right_census;  // the right one mirrored, as the whole right picture is
    const Byte* right_colors;
    std::size_t right_stride;  // distance between planes
    ColorView left;
    const SearchWindow* windows;
    int y, width;
    DisparityRange range;
};

// The bytes of one pixel of the left picture.
struct OwnBytes {
    Byte census[kPlanes], colors[3];
};

// Computes the census' Hamming distances of a run. `right` points to the right pixel at the first disparity;
// the following pixels belong to larger disparities.
template <int kRun>
HEXRELIEF_INLINED void hamming_distances(const OwnBytes& own, const Byte* __restrict right,
                                         std::size_t stride, Byte* __restrict out) {
    const Byte* __restrict r0 = right;
    const Byte* __restrict r1 = r0 + stride;
    const Byte* __restrict r2 = r1 + stride;
    const Byte* __restrict r3 = r2 + stride;
    const Byte* __restrict r4 = r3 + stride;
    const Byte* __restrict r5 = r4 + stride;
    const Byte* __restrict r6 = r5 + stride;
    const Byte* __restrict r7 = r6 + stride;
    const Byte l0 = own.census[0], l1 = own.census[1], l2 = own.census[2], l3 = own.census[3];
    const Byte l4 = own.census[4], l5 = own.census[5], l6 = own.census[6], l7 = own.census[7];
    for (int d = 0; d < kRun; ++d) {
        const BitSum a = add_bits(l0 ^ r0[d], l1 ^ r1[d], l2 ^ r2[d]);
        const BitSum b = add_bits(a.sum, l3 ^ r3[d], l4 ^ r4[d]);
        const BitSum c = add_bits(b.sum, l5 ^ r5[d], l6 ^ r6[d]);
        const Byte last = l7 ^ r7[d];
        const Byte ones = c.sum ^ last;
        const BitSum e = add_bits(a.carry, b.carry, c.carry);
        const Byte carry = c.sum & last;
        const Byte twos = e.sum ^ carry, more = e.sum & carry;
        const Byte fours = e.carry ^ more, eights = e.carry & more;
        out[d] = static_cast<Byte>(set_bits(ones, twos) + 4 * set_bits(fours, eights));
    }
}

template <int kRun>
HEXRELIEF_INLINED void add_colors(const OwnBytes& own, const Byte* __restrict right, std::size_t stride,
                                  int channels, Byte* __restrict costs) {
    if (channels == 3) {
        const Byte* __restrict red = right;
        const Byte* __restrict green = red + stride;
        const Byte* __restrict blue = green + stride;
        const Byte own_red = own.colors[0], own_green = own.colors[1], own_blue = own.colors[2];
        for (int d = 0; d < kRun; ++d) {
            const Byte differences =
                static_cast<Byte>(step::cut_difference(step::distance(own_red, red[d])) +
                                  step::cut_difference(step::distance(own_green, green[d])) +
                                  step::cut_difference(step::distance(own_blue, blue[d])));
            costs[d] = step::matching_cost(costs[d], differences, 3);
        }
    } else {
        const Byte own_grey = own.colors[0];
        for (int d = 0; d < kRun; ++d)
            costs[d] =
                step::matching_cost(costs[d], step::cut_difference(step::distance(own_grey, right[d])), 1);
    }
}

template <int kRun>
HEXRELIEF_INLINED void cost_row_in_runs(const CostRowView& row, Byte* __restrict costs) {
    for (int x = 0; x < row.width; ++x) {
        OwnBytes own{};
        for (int k = 0; k < kPlanes; ++k) own.census[k] = row.left_census[k * row.width + x];
        for (int c = 0; c < row.left.channels; ++c) own.colors[c] = row.left.planes[c].at(x, row.y);
        const int right = row.width - 1 - x;
        Byte* out = costs + static_cast<std::size_t>(x) * 2 * kRun;
        for (const int first : {row.windows[x].far_run, row.windows[x].near_run}) {
            hamming_distances<kRun>(own, row.right_census + right + first, row.right_stride, out);
            add_colors<kRun>(own, row.right_colors + right + first, row.right_stride, row.left.channels, out);
            for (int d = std::max(0, row.range.count - first); d < kRun; ++d) out[d] = kBeyondRange;
            out += kRun;
        }
    }
}
HEXRELIEF_SMALL_VECTORS void cost_row(const CostRowView& row, Byte* __restrict costs) {
    if (is_searched_wholly(row.range))
        cost_row_in_runs<kLongRun>(row, costs);
    else
        cost_row_in_runs<kShortRun>(row, costs);
}

}  // namespace

CostRows::CostRows(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                   WindowView windows)
    : left_(left),
      right_(right),
      range_(range),
      windows_(windows),
      mirrored_width_(static_cast<std::size_t>(left.width()) + range.count + kWholeRange),
      left_census_(static_cast<std::size_t>(kPlanes) * left.width()),
      right_census_(left_census_.size()),
      mirrored_census_(kPlanes * mirrored_width_),
      mirrored_colors_(left.channels * mirrored_width_) {}

void CostRows::compute(int y, Byte* costs) {
    const int width = left_.width();
    census_row(left_.grey.view(), y, left_census_.data());
    census_row(right_.grey.view(), y, right_census_.data());
    for (std::size_t i = 0; i < mirrored_width_; ++i) {
        const int x = std::clamp(width - 1 - range_.min_px - static_cast<int>(i), 0, width - 1);
        for (int k = 0; k < kPlanes; ++k)
            mirrored_census_[k * mirrored_width_ + i] =
                right_census_[static_cast<std::size_t>(k) * width + x];
        for (int c = 0; c < right_.channels; ++c)
            mirrored_colors_[c * mirrored_width_ + i] = right_.planes[c].view().at(x, y);
    }
    cost_row({left_census_.data(), mirrored_census_.data(), mirrored_colors_.data(), mirrored_width_,
              view_of(left_), windows_.row(y), y, width, range_},
             costs);
}

}  // namespace hexrelief::matching
