#include "tests/pipeline/checks/patterns.h"

#include <cstdint>
#include <stdexcept>

namespace hexrelief::checks {
namespace {

// Returns 0 .. 99, a hash of the pixel (Wellons' lowbias32).
unsigned percent_at(int x, int y) {
    std::uint32_t h = static_cast<std::uint32_t>(y) * 65536u + static_cast<std::uint32_t>(x);
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return (h ^ (h >> 16)) % 100;
}

bool is_on_scan_line(int x, int y) {
    constexpr int kApart = 8, kWave_px = 128;
    const int phase = x % kWave_px, wave = (phase < kWave_px / 2 ? phase : kWave_px - phase) * 4 / kWave_px;
    const int line = y - wave - static_cast<int>(percent_at(x, 1 << 14) % 2);
    return (line + kApart) % kApart == kApart / 2 && percent_at(x, y) < 60;
}

bool keeps(const std::string& pattern, int x, int y) {
    if (pattern == "random-20") return percent_at(x, y) < 20;
    if (pattern == "random-5") return percent_at(x, y) < 5;
    if (pattern == "rows-20") return y % 5 == 2;
    if (pattern == "rows-5") return y % 20 == 10;
    if (pattern == "laser") return is_on_scan_line(x, y);
    throw std::logic_error("no pattern " + pattern);
}

}  // namespace

const std::vector<std::string>& patterns() {
    static const std::vector<std::string> all{"random-20", "random-5", "rows-20", "rows-5", "laser"};
    return all;
}

DisparityMap thinned(const DisparityMap& map, const std::string& pattern) {
    DisparityMap thin = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (!keeps(pattern, x, y)) thin.at(x, y) = kUnknownDisparity;
    return thin;
}

}  // namespace hexrelief::checks
