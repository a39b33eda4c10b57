// The settings that all tiles of a pair share: the range of disparities that is searched, and the
// correction of the pictures.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/readers/windows/picture_windows.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::tiles {

struct PairWindows {
    const readers::PictureWindows &left, &right;
};

// Returns the configuration's range, else the calibration's, else the range found in the whole pair,
// which is shrunk by a whole number if it has more than 16 Mpx. The correction of light and `coarse`
// come from the shrunk pair, the noise from the middle of the full one. A pair that is not shrunk
// gets the same as from find_range(), except that the range is not rounded up. Writes the range to
// the log. Throws as check_matchable().
stages::FoundRange find_range_of_whole(const PairWindows& pair, const Calibration& calibration,
                                       const stages::DisparityConfig& config, int threads, job::RunLog& log);

}  // namespace hexrelief::tiles
