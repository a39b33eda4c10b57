// What all tiles of a pair have in common: the range of disparities that is searched, and what is done to
// the pictures before.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/job/run_log.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/windows/picture_windows.h"

namespace hexrelief::tiles {

struct PairWindows {
    const windows::PictureWindows &left, &right;
};

struct WholePair {
    stages::DisparityConfig config;  // with the range
    stages::PairCorrection correction;
};

// The range is the configuration's own, else the calibration's, else the one found in the whole pair, shrunk
// by a whole number where it has more than 16 Mpx; the light is that of this pair, the noise that of the
// whole one's middle. Pairs that are not shrunk get what choose_range() gives. Tells the log of it. Throws as
// check_matchable().
WholePair look_at_whole(const PairWindows& pair, const Calibration& calibration,
                        const stages::DisparityConfig& config, int threads, job::RunLog& log);

}  // namespace hexrelief::tiles
