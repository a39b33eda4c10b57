// The range of disparities that all tiles of a pair are searched in.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/job/run_log.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/windows/picture_windows.h"

namespace hexrelief {

struct PairWindows {
    const PictureWindows &left, &right;
};

// The configuration with the range: its own, else the calibration's, else the one found in the whole pair,
// shrunk by a whole number where it has more than 16 Mpx. Pairs that are not shrunk get the range that
// choose_range() gives. Tells the log of it. Throws as check_matchable().
DisparityConfig range_of_whole(const PairWindows& pair, const Calibration& calibration,
                               const DisparityConfig& config, int threads, RunLog& log);

}  // namespace hexrelief
