// Fits maps to pictures whose sides a network rounded.
#pragma once

#include <filesystem>
#include <string>

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

}  // namespace hexrelief::job
