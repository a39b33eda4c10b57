// The settings that all tiles of a pair share: the range of disparities that is searched, and the
// correction of the pictures.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/job/run_log.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/windows/picture_windows.h"

namespace hexrelief::tiles {

struct PairWindows {
    const windows::PictureWindows &left, &right;
};

// The range is the configuration's own, else the calibration's, else the one found in the whole pair, shrunk
// by a whole number where it has more than 16 Mpx; the light is that of this pair, the noise that of the
// whole one's middle. Pairs that are not shrunk get what find_range() gives, but for a range that is not
// rounded up; of others `coarse` is that of the shrunk pair. Tells the log of it. Throws as
// check_matchable().
stages::FoundRange find_range_of_whole(const PairWindows& pair, const Calibration& calibration,
                                       const stages::DisparityConfig& config, int threads, job::RunLog& log);

}  // namespace hexrelief::tiles
