#include "pipeline/job/maps/mask_input.h"

#include "pipeline/data/disparity_map.h"

namespace hexrelief {

void hide(std::vector<float>& values, const PixelMask& mask) {
    for (std::size_t i = 0; i < mask.kept.size(); ++i)
        if (!mask.kept[i]) values[i] = kUnknownDisparity;
}

PixelMask both(PixelMask a, const PixelMask& b) {
    if (a.empty()) return b;
    for (std::size_t i = 0; i < b.kept.size(); ++i) a.kept[i] &= b.kept[i];
    return a;
}

}  // namespace hexrelief
