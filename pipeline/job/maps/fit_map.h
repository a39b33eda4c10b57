// Fits maps to pictures whose sides a network rounded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/depth_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// Changes a map whose aspect differs from its picture's: cuts it evenly if it is the picture padded to
// multiples of 8 to 128, or repeats and leaves out rows if the aspect is at most 3 % off, as after rounding
// to multiples of 14 or 16. Columns stay, and so disparities. Returns what was done; empty = nothing.
std::string fit_to_picture(DisparityMap& map, int width, int height);
std::string fit_to_picture(DepthMap& map, int width, int height);
std::string fit_to_picture(readers::PixelMask& mask, int width, int height);

// The picture of a map's view at the map's size, and unscaled if that differs; else that is empty.
struct ViewPicture {
    Image color, picture = {};
};
// Throws Error(input) if the aspects differ. The paths are for the message.
ViewPicture picture_of_view(Image image, const std::filesystem::path& path, ViewSize view,
                            const std::filesystem::path& map_path);

// Returns the mask at the view's size; a mask of a rounded map is fitted to the picture as the map was.
// Throws Error(input) if the aspects differ; path is for the message.
readers::PixelMask fitted(readers::PixelMask mask, ViewSize view, const Image& picture,
                          const std::filesystem::path& path);

// A mask or confidences, from a file or from an array; empty = none.
struct MaskSource {
    std::filesystem::path file;
    readers::PixelMask array = {};

    // Returns the name for messages.
    std::filesystem::path name(const char* in_memory) const {
        return file.empty() ? std::filesystem::path(in_memory) : file;
    }
};

// Sets values that the mask does not keep to unknown (+infinity). The values are those of a map of the mask's
// size; an empty mask keeps all.
void hide(std::vector<float>& values, const readers::PixelMask& mask);
// Hides the same pixels of a map, and sets the origins of its unknown pixels, if it has origins, to unknown.
void hide(DisparityMap& map, const readers::PixelMask& mask);

// Returns the mask of the image's opaque pixels; empty if it has no alpha. Throws Error(input) if
// no pixel is opaque.
readers::PixelMask opaque_part(const Image& image);

// Returns the mask of the pixels that both masks keep. An empty mask keeps all.
readers::PixelMask both(readers::PixelMask a, const readers::PixelMask& b);

// Returns the share of pixels with this value, in percent with one decimal.
std::string percent_text(const readers::PixelMask& mask, std::uint8_t value);

}  // namespace hexrelief::job
