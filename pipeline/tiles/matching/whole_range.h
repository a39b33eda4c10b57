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

struct WholePair {
    stages::DisparityConfig config;  // with the range
    stages::PairCorrection correction;
};

// Finds the settings. The range is the configuration's own, else the calibration's, else the one found in the
// whole pair, shrunk by an integer factor if it has more than 16 Mpx. The light is found in this pair, the
// noise in the middle of the full-size pictures. For pairs that are not shrunk the range is that of
// choose_range(). Writes the range to the log. Throws what check_matchable() throws.
WholePair look_at_whole(const PairWindows& pair, const Calibration& calibration,
                        const stages::DisparityConfig& config, int threads, job::RunLog& log);

}  // namespace hexrelief::tiles
