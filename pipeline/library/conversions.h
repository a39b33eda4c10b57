// What the library is given, as the pipeline takes it.
#pragma once

#include <hexrelief/hexrelief.h>

#include "pipeline/config/config.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::library {

// A copy. `name` stands in messages. Throws Error(input) where there are not 1 to 4 channels.
Image image_of(const ImageView& view, const std::string& name);
// Throws Error(input) as read_disparity_map().
DisparityMap map_of(const MapView& view, const readers::DisparityFileConfig& config);

// Throw Error(input) as those that read the same from files.
readers::DepthFile depth_of(const MapView& view, const readers::DepthFileConfig& config);
readers::PixelMask mask_of(const ImageView& view, const readers::MaskConfig& config);
readers::PixelMask confidence_of(const MapView& view, const readers::ConfidenceConfig& config);

// As the command line reads --config, --set, its direct options and what it is told of the camera. `files`:
// the options of the files that are read, as far as direct options go with them. Throws Error(usage).
config::Config config_of(const Options& options, const Camera& camera,
                         const std::vector<std::string>& files = {});

// Settings of `export` on top of a configuration. Throws Error(usage) for other keys.
void apply_export_settings(config::Config& config, const Options& options);
bool sets_tolerance(const Options& options);

}  // namespace hexrelief::library
