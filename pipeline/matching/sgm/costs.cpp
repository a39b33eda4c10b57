#include "pipeline/matching/sgm/costs.h"

#include <algorithm>

#include "mesher/common/simd.h"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief {
namespace {

using Byte = std::uint8_t;

// The census of a row in eight planes of a byte a pixel: that many pixels' bits are compared at once.
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

// Bits of equal weight added without carries: three bytes' bits become a sum and a carry.
struct BitSum {
    Byte sum, carry;
};
HEXRELIEF_INLINED BitSum add_bits(Byte a, Byte b, Byte c) {
    const Byte either = a ^ b;
    return {static_cast<Byte>(either ^ c), static_cast<Byte>((a & b) | (either & c))};
}
HEXRELIEF_INLINED Byte set_bits(Byte v) {
    v = static_cast<Byte>(v - ((v >> 1) & 0x55));
    v = static_cast<Byte>((v & 0x33) + ((v >> 2) & 0x33));
    return static_cast<Byte>((v + (v >> 4)) & 0x0f);
}

// Where a pixel's eight bytes and those of its possible matches lie.
struct CensusBytes {
    const Byte *left,
        *right;  // right: the pixel at the least disparity; the next ones lie at the larger ones
    std::size_t left_stride, right_stride;  // from plane to plane
};

// The census' Hamming distances at all disparities.
HEXRELIEF_INLINED void hamming_distances(const CensusBytes& at, int count, Byte* __restrict out) {
    const Byte* __restrict r0 = at.right;
    const Byte* __restrict r1 = r0 + at.right_stride;
    const Byte* __restrict r2 = r1 + at.right_stride;
    const Byte* __restrict r3 = r2 + at.right_stride;
    const Byte* __restrict r4 = r3 + at.right_stride;
    const Byte* __restrict r5 = r4 + at.right_stride;
    const Byte* __restrict r6 = r5 + at.right_stride;
    const Byte* __restrict r7 = r6 + at.right_stride;
    Byte own[kPlanes];
    for (int k = 0; k < kPlanes; ++k) own[k] = at.left[k * at.left_stride];
    const Byte l0 = own[0], l1 = own[1], l2 = own[2], l3 = own[3];
    const Byte l4 = own[4], l5 = own[5], l6 = own[6], l7 = own[7];
    for (int d = 0; d < count; ++d) {
        const BitSum a = add_bits(l0 ^ r0[d], l1 ^ r1[d], l2 ^ r2[d]);
        const BitSum b = add_bits(a.sum, l3 ^ r3[d], l4 ^ r4[d]);
        const BitSum c = add_bits(b.sum, l5 ^ r5[d], l6 ^ r6[d]);
        const Byte last = l7 ^ r7[d];
        const Byte ones = c.sum ^ last;
        const BitSum e = add_bits(a.carry, b.carry, c.carry);
        const Byte carry = c.sum & last;
        const Byte twos = e.sum ^ carry, more = e.sum & carry;
        const Byte fours = e.carry ^ more, eights = e.carry & more;
        out[d] = static_cast<Byte>(set_bits(ones) + 2 * set_bits(twos) + 4 * set_bits(fours) +
                                   8 * set_bits(eights));
    }
}

HEXRELIEF_INLINED void add_colors(const Byte* const own, const Byte* __restrict right, std::size_t stride,
                                  int channels, int count, Byte* __restrict costs) {
    if (channels == 3) {
        const Byte* __restrict red = right;
        const Byte* __restrict green = red + stride;
        const Byte* __restrict blue = green + stride;
        const Byte own_red = own[0], own_green = own[1], own_blue = own[2];
        for (int d = 0; d < count; ++d) {
            const Byte differences = static_cast<Byte>(step::cut_difference(own_red, red[d]) +
                                                       step::cut_difference(own_green, green[d]) +
                                                       step::cut_difference(own_blue, blue[d]));
            costs[d] = step::matching_cost(costs[d], differences, 3);
        }
    } else {
        const Byte own_grey = own[0];
        for (int d = 0; d < count; ++d)
            costs[d] = step::matching_cost(costs[d], step::cut_difference(own_grey, right[d]), 1);
    }
}

struct CostRowView {
    const Byte *left_census, *right_census;  // the right one mirrored, as all of the right picture is
    const Byte* right_colors;
    std::size_t right_stride;
    ColorView left;
    int y, width, count;
};

HEXRELIEF_SMALL_VECTORS void cost_row(const CostRowView& row, Byte* __restrict costs) {
    const int width = row.width, count = row.count, channels = row.left.channels;
    for (int x = 0; x < width; ++x) {
        const std::size_t first = static_cast<std::size_t>(width - 1 - x);
        Byte* out = costs + static_cast<std::size_t>(x) * count;
        hamming_distances({row.left_census + x, row.right_census + first, static_cast<std::size_t>(width),
                           row.right_stride},
                          count, out);
        Byte own[3] = {};
        for (int c = 0; c < channels; ++c) own[c] = row.left.planes[c].at(x, row.y);
        add_colors(own, row.right_colors + first, row.right_stride, channels, count, out);
    }
}

}  // namespace

CostRows::CostRows(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range)
    : left_(left),
      right_(right),
      range_(range),
      mirrored_width_(static_cast<std::size_t>(left.width()) + range.count),
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
              view_of(left_), y, width, range_.count},
             costs);
}

}  // namespace hexrelief
