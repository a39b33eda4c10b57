#include "exporters/viewer/small_picture.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "exporters/images/image_writer.h"
#include "exporters/images/resize.h"
#include "exporters/viewer/html_text.h"

namespace hexrelief::exporters {
namespace {

// Longer side in px, and quality; the best first.
constexpr std::pair<int, int> kSizes[] = {{480, 75}, {480, 50}, {360, 40}, {240, 30}, {120, 30}};
constexpr std::size_t kMostBytes = 16000;

Image shrunk(const Image& image, int longest_px) {
    const double scale = static_cast<double>(longest_px) / std::max(image.width, image.height);
    if (scale >= 1) return image;
    const auto side = [&](int size) { return std::max(1, static_cast<int>(size * scale)); };
    return resized(image, side(image.width), side(image.height));
}

}  // namespace

std::string small_picture(const Image& image) {
    std::vector<std::uint8_t> bytes;
    for (const auto& [longest_px, quality] : kSizes) {
        bytes = encode_webp(shrunk(image, longest_px), quality);
        if (bytes.size() <= kMostBytes) break;
    }
    return "data:image/webp;base64," + base64(bytes);
}

}  // namespace hexrelief::exporters
