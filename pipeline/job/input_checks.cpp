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

namespace hexrelief::job {
namespace {

// True if the disparities are right in spite of this finding.
bool leaves_disparities(const checks::Finding& finding) {
    return finding.mistake == checks::Mistake::range_wide ||
           finding.mistake == checks::Mistake::range_ends_low ||
           finding.mistake == checks::Mistake::rows_differ ||
           finding.mistake == checks::Mistake::rows_flipped ||
           finding.mistake == checks::Mistake::color_mirrored ||
           finding.mistake == checks::Mistake::color_elsewhere ||
           finding.mistake == checks::Mistake::color_unrelated;
}

}  // namespace

void check_input(const RunInput& input, const stages::FoundRange& range, const config::Config& config,
                 int threads, RunLog& log) {
    const InputPair* const pair = input.pair();
    const InputMap* const map = input.map();
    // The matcher refuses a blank picture; any other finding would be spurious.
    if (pair && (checks::is_blank(pair->views.left) || checks::is_blank(pair->views.right))) return;
    const bool is_depth = map && map->is_depth;
    std::vector<checks::Finding> findings;
    if (pair) {
        const stages::DisparityConfig& searched = range.config;
        findings = checks::check_pair(pair->views, range.coarse,
                                      {searched.min_disparity_px, searched.num_disparities_px}, range.origin,
                                      threads);
    } else {
        const readers::DisparityFileConfig& file = config.input.disparity;
        findings = checks::check_map(map->disparities, map->color,
                                     is_depth ? checks::MapKind::depth : checks::MapKind::disparity,
                                     {file.scale > 0 ? file.scale : 1, file.offset_px});
    }
    double median_px = std::numeric_limits<double>::quiet_NaN();
    if (input.calibration.metric && std::all_of(findings.begin(), findings.end(), leaves_disparities))
        median_px = pair ? checks::median_disparity_px(range.coarse)
                         : checks::measure_values(map->disparities).median_px;
    for (checks::Finding& finding : is_depth ? checks::check_depths(input.calibration, median_px)
                                             : checks::check_camera(input.calibration, median_px))
        findings.push_back(std::move(finding));
    for (checks::Finding& finding : checks::check_focal(input.calibration))
        findings.push_back(std::move(finding));
    for (const checks::Finding& finding : findings) {
        if (config.run.strict) throw Error(ErrorKind::input, finding.text);
        log.warn(finding.text);
    }
}

}  // namespace hexrelief::job
