// Prepares supplied maps: makes disparities that have no depth unknown, looks at the scale that was assumed,
// converts depths, and fits maps to pictures whose sides a network rounded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/depth_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::job {

// Makes disparities unknown that do not lie in front of infinity, which is at -doffs_px. Returns warnings: of
// a sign that may be turned, and of an assumed scale that makes all disparities small. Throws Error(input) if
// no disparity remains.
std::vector<std::string> keep_in_front(readers::DisparityFile& file, double doffs_px);

struct DepthInput {
    DisparityMap map;
    std::vector<std::string> decisions;  // how the samples were read, and a baseline that was chosen
    bool is_baseline_chosen = false;     // true if the depths chose the baseline
};

// Converts depths to disparities. `camera` is the depth map's; if its baseline is unknown (0), or the depths
// are relative, the baseline is chosen by the depths (stages/depth.h). The camera becomes metric if the
// depths are and the focal length is known. Throws Error(input) if near_m and far_m leave no depth.
DepthInput take_depths(readers::DepthFile file, const readers::DepthFileConfig& config, bool is_focal_known,
                       Calibration& camera);

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
