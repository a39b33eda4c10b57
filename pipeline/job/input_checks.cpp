#include "pipeline/job/input_checks.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "pipeline/checks/check_camera.h"
#include "pipeline/checks/check_map.h"
#include "pipeline/checks/check_pair.h"
#include "pipeline/checks/map_statistics.h"
#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

// The disparities themselves are then right.
bool leaves_disparities(const Finding& finding) {
    return finding.mistake == Mistake::range_wide || finding.mistake == Mistake::range_ends_low ||
           finding.mistake == Mistake::rows_differ || finding.mistake == Mistake::color_elsewhere ||
           finding.mistake == Mistake::color_unrelated;
}

}  // namespace

void check_input(const RunInput& input, const FoundRange& range, const Config& config, int threads,
                 RunLog& log) {
    const InputPair* const pair = input.pair();
    const InputMap* const map = input.map();
    // The matcher refuses a blank picture: whatever is said beside that is made up.
    if (pair && (is_blank(pair->views.left) || is_blank(pair->views.right))) return;
    const bool is_depth = map && map->is_depth();
    std::vector<Finding> findings;
    if (pair) {
        const DisparityConfig& searched = range.config;
        findings =
            check_pair(pair->views, range.coarse, {searched.min_disparity_px, searched.num_disparities_px},
                       range.origin, threads);
    } else {
        const DisparityFileConfig& file = config.input.disparity;
        findings = check_map(map->disparities, map->color, is_depth ? MapKind::depth : MapKind::disparity,
                             {file.scale > 0 ? file.scale : 1, file.offset_px});
    }
    double median_px = std::numeric_limits<double>::quiet_NaN();
    if (input.calibration.metric && std::all_of(findings.begin(), findings.end(), leaves_disparities))
        median_px = pair ? median_disparity_px(range.coarse) : measure_values(map->disparities).median_px;
    for (Finding& finding :
         is_depth ? check_depths(input.calibration, median_px) : check_camera(input.calibration, median_px))
        findings.push_back(std::move(finding));
    for (const Finding& finding : findings) {
        if (config.run.strict) throw Error(ErrorKind::input, finding.text);
        log.warn(finding.text);
    }
}

}  // namespace hexrelief
