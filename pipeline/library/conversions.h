// Converts the library's types to the pipeline's.
#pragma once

#include <hexrelief/hexrelief.h>
#include <hexrelief/run.h>

#include "pipeline/config/config.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/job/report.h"
#include "pipeline/job/request.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::library {

// Returns a copy. `name` is for messages. Throws Error(input) unless there are 1 to 4 channels.
Image image_of(const ImageView& view, const std::string& name);
// Returns the disparities that the samples stand for. Throws Error(input) as read_disparity_map().
readers::DisparityFile map_of(const MapView& view, const readers::DisparityFileConfig& config);

// Return what the readers of files return for the same samples, and throw Error(input) as those readers do.
readers::DepthFile depth_of(const MapView& view, const readers::DepthFileConfig& config);
readers::PixelMask mask_of(const ImageView& view, const readers::MaskConfig& config);
readers::PixelMask confidence_of(const MapView& view, const readers::ConfidenceConfig& config);

// Returns the configuration that the command line makes of --config, --set, its direct options and
// the camera's options. `files`: the options of the files that are read; direct options may depend
// on them. Throws Error(usage).
config::Config config_of(const Options& options, const Camera& camera,
                         const std::vector<std::string>& files = {});

// Applies settings of `export` on top of a configuration. Throws Error(usage) for other keys.
void apply_export_settings(config::Config& config, const Options& options);
bool sets_tolerance(const Options& options);

// Returns the request of a run. Throws Error(usage).
job::RunRequest request_of(const FileRequest& files, const Options& options);

// Connects the log's events to the caller's functions, which may be empty.
void tell_caller(const Options& options, job::RunLog& log);

RunSummary summary_of(const job::RunReport& report);

}  // namespace hexrelief::library
