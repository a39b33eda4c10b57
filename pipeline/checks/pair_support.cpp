#include "pipeline/checks/pair_support.h"

#include <algorithm>
#include <cstddef>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/checks/point_matches.h"
#include "pipeline/checks/thresholds.h"

namespace hexrelief::checks {

double measure_support(const Image& left, const DisparityMap& map, const std::vector<std::uint8_t>& is_kept) {
    const GreyImage grey = grey_of(left);
    long long textured = 0, agreed = 0;
    const auto count = [&](int x, int y) {
        const std::size_t i = static_cast<std::size_t>(y) * map.width + x;
        if (!is_kept.empty() && !is_kept[i]) return;
        if (DisparityMap::known(map.values[i]) && map.values[i] > static_cast<float>(x)) return;
        ++textured;
        agreed += map.origins[i] == PixelOrigin::matched;
    };
    for (int top = 0; top + kBlock_px <= grey.height; top += kBlock_px)
        for (int first = 0; first + kBlock_px <= grey.width; first += kBlock_px) {
            if (!is_textured(grey, first, top)) continue;
            for (int y = top; y < top + kBlock_px; ++y)
                for (int x = first; x < first + kBlock_px; ++x) count(x, y);
        }
    return textured == 0 ? 0 : static_cast<double>(agreed) / static_cast<double>(textured);
}

const char* support_word(double support) {
    return support >= kGoodSupport ? "good" : is_hardly_supported(support) ? "hardly" : "partly";
}

bool is_hardly_supported(double support) {
    return support < kLeastSupport;
}

}  // namespace hexrelief::checks
