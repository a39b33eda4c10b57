// What a page (.html) shows beside the relief: figures and pictures of the stages.
#pragma once

#include <filesystem>
#include <vector>

#include "exporters/core/scene.h"
#include "pipeline/job/steps.h"

namespace hexrelief::job {

// Whether one of the outputs is a page.
bool has_page(const std::vector<std::filesystem::path>& outputs);

exporters::PageContent page_content(const LeftView& view, const SurfaceResult& result,
                                    const SurfaceMeasures& measures, int threads);

}  // namespace hexrelief::job
