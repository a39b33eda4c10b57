#include "pipeline/readers/windows/window_source.h"

#include <algorithm>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/limits.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers {

void check_map_size(const std::filesystem::path& path, unsigned long long width, unsigned long long height) {
    if (width == 0 || height == 0)
        codec::refuse(path, "its size is " + size_text(width, height) + "; both sides must be at least 1");
    if (std::max(width, height) > kLargestMapSide_px)
        codec::refuse(path, "its size is " + size_text(width, height) + ", more than the limit of " +
                                std::to_string(kLargestMapSide_px) + " px a side; cut it into several first");
}

codec::Raster read_window(const WindowSource& source, const std::filesystem::path& path,
                          const WantedWindow& window) {
    const auto within = [](long long at, long long size, long long all) {
        return at >= 0 && size >= 1 && at + size <= all;
    };
    const std::string wanted = size_text(window.width, window.height);
    if (!within(window.x, window.width, source.width) || !within(window.y, window.height, source.height))
        codec::refuse(path, "there is no window of " + wanted + " px at " + std::to_string(window.x) + "," +
                                std::to_string(window.y) + " in its " +
                                size_text(source.width, source.height) + " px; ask for one inside");
    if (static_cast<long long>(window.width) * window.height > kMaxPixels)
        codec::refuse(path, "a window of " + wanted + " px is above the limit of " +
                                std::to_string(kMaxPixels) + " pixels; ask for smaller ones");
    const auto at = [](int value) { return static_cast<std::uint32_t>(value); };
    return source.read({at(window.x), at(window.y), at(window.width), at(window.height)});
}

codec::Raster no_samples(const WindowSource& source) {
    codec::Raster raster;
    if (source.sample == MapSample::uint16) raster.samples = std::vector<std::uint16_t>();
    if (source.sample == MapSample::float32) raster.samples = std::vector<float>();
    return raster;
}

}  // namespace hexrelief::readers
