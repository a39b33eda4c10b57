// Makes disparities that have no depth unknown, and looks at the scale that was assumed.
#pragma once

#include <string>
#include <vector>

#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::job {

// Makes disparities unknown that do not lie in front of infinity, which is at -doffs_px. Returns warnings: of
// a sign that may be turned, and of an assumed scale that makes all disparities small. Throws Error(input) if
// no disparity remains.
std::vector<std::string> keep_in_front(readers::DisparityFile& file, double doffs_px);

}  // namespace hexrelief::job
