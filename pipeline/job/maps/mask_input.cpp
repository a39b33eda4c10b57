#include "pipeline/job/maps/mask_input.h"

#include <algorithm>
#include <cstdio>

#include "pipeline/data/error.h"

namespace hexrelief::job {

void hide(std::vector<float>& values, const readers::PixelMask& mask) {
    for (std::size_t i = 0; i < mask.kept.size(); ++i)
        if (!mask.kept[i]) values[i] = kUnknownDisparity;
}

void hide(DisparityMap& map, const readers::PixelMask& mask) {
    hide(map.values, mask);
    for (std::size_t i = 0; i < map.origins.size(); ++i)
        if (!DisparityMap::known(map.values[i])) map.origins[i] = PixelOrigin::unknown;
}

readers::PixelMask opaque_part(const Image& image) {
    readers::PixelMask mask{image.width, image.height, image.alpha};
    for (std::uint8_t& kept : mask.kept) kept = kept >= kOpaque;
    if (!mask.empty() && std::ranges::find(mask.kept, 1) == mask.kept.end())
        throw Error(
            ErrorKind::input,
            "every pixel of the left picture is transparent, so nothing is known; set input.mask.alpha "
            "to false where its alpha means nothing");
    return mask;
}

readers::PixelMask both(readers::PixelMask a, const readers::PixelMask& b) {
    if (a.empty()) return b;
    for (std::size_t i = 0; i < b.kept.size(); ++i) a.kept[i] &= b.kept[i];
    return a;
}

std::string percent_text(const readers::PixelMask& mask, std::uint8_t value) {
    char text[16];
    std::snprintf(text, sizeof text, "%.1f",
                  100.0 * static_cast<double>(std::ranges::count(mask.kept, value)) /
                      static_cast<double>(mask.kept.size()));
    return text;
}

}  // namespace hexrelief::job
