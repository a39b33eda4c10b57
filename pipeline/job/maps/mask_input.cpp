#include "pipeline/job/maps/mask_input.h"

namespace hexrelief {

void hide(std::vector<float>& values, const PixelMask& mask) {
    for (std::size_t i = 0; i < mask.kept.size(); ++i)
        if (!mask.kept[i]) values[i] = kUnknownDisparity;
}

void hide(DisparityMap& map, const PixelMask& mask) {
    hide(map.values, mask);
    for (std::size_t i = 0; i < map.origins.size(); ++i)
        if (!DisparityMap::known(map.values[i])) map.origins[i] = PixelOrigin::unknown;
}

PixelMask both(PixelMask a, const PixelMask& b) {
    if (a.empty()) return b;
    for (std::size_t i = 0; i < b.kept.size(); ++i) a.kept[i] &= b.kept[i];
    return a;
}

}  // namespace hexrelief
