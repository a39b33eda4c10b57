#include "pipeline/job/tolerance.h"

#include <algorithm>

#include "pipeline/stages/surface_quality.h"

namespace hexrelief {

double tolerance_for(const ExportConfig& config, const SurfaceMesh& surface, const DisparityMap& map,
                     float background_px, int threads) {
    if (!(config.tolerance_share > 0)) return config.tolerance_px;
    const double error_px = measure_surface_quality(surface, map, background_px, threads).flat_rmse_px;
    // rounded, because machines may differ in the last bits of the measured error
    const double wanted_px =
        std::max(kLeastTolerance_px, 1e-3 * static_cast<long long>(1e3 * config.tolerance_share * error_px));
    return std::min(config.tolerance_px, wanted_px);
}

}  // namespace hexrelief
