// Figures and pictures of the stages, shown on a page (.html) beside the relief.
#pragma once

#include <filesystem>
#include <vector>

#include "exporters/core/scene.h"
#include "pipeline/job/relief.h"
#include "pipeline/stages/surface_quality.h"

namespace hexrelief::job {

// True if one of the outputs is a page.
bool has_page(const std::vector<std::filesystem::path>& outputs);

exporters::PageContent page_content(const LeftView& view, const SurfaceResult& result,
                                    const stages::SurfaceQuality& quality, int threads);

}  // namespace hexrelief::job
