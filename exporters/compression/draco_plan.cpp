#include "exporters/compression/draco_plan.h"

#include <cmath>
#include <utility>

#include "exporters/compression/draco_box.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

// True if the values that a decoder will return keep the tolerance.
bool keeps_tolerance(const DracoPlan& plan, const TexturedMesh& textured, const Calibration* camera,
                     double tolerance_px) {
    const DracoQuantisation& q = plan.quantisation;
    if (q.positions && camera &&
        !(position_error_px(plan.mesh, *camera, *q.positions, plan.transform, q.exact_boxes) <= tolerance_px))
        return false;
    return !q.texcoords || texcoord_error_px(plan.mesh.texcoords, textured.width_px, textured.height_px,
                                             *q.texcoords, q.exact_boxes) <= tolerance_px;
}

}  // namespace

std::vector<Vec3f> scaled_normals(const std::vector<Vec3f>& normals, const std::array<double, 3>& scale) {
    std::vector<Vec3f> out;
    out.reserve(normals.size());
    for (const Vec3f& n : normals) {
        const double x = n.x * scale[0], y = n.y * scale[1], z = n.z * scale[2];
        const double length = std::sqrt(x * x + y * y + z * z);
        out.push_back(
            {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)});
    }
    return out;
}

DracoPlan plan_draco(const TexturedMesh& textured, const Calibration* camera, const ExportConfig& config,
                     GridShape shape, int threads) {
    DracoPlan plan{textured.mesh, {}, {}};
    SurfaceMesh& mesh = plan.mesh;
    DracoQuantisation& quantisation = plan.quantisation;
    quantisation.level = config.draco.level;
    const bool is_on_grid = textured.grid_step_m > 0;
    if (config.draco.position_bits > 0 && !is_on_grid) {
        quantisation.position_bits = config.draco.position_bits;
    } else if (camera || is_on_grid) {
        Grid<3> grid = is_on_grid ? exact_grid(mesh.positions, textured.grid_step_m)
                                  : quantise_positions(mesh, *camera, config.tolerance_px, shape, threads);
        if (shape == GridShape::per_axis) {
            // Cells are counted from the camera: a translation would cost near vertices the last
            // bits of their floats.
            plan.transform.scale = grid.step;
            for (int axis = 0; axis < 3; ++axis) {
                grid.origin[axis] = std::round(grid.origin[axis] / grid.step[axis]);
                grid.step[axis] = 1;
            }
        }
        quantisation.positions = std::move(grid);
    }
    const auto& scale = plan.transform.scale;
    if (config.draco.normal_bits > 0) {
        quantisation.normal_bits = config.draco.normal_bits;
    } else {
        quantisation.normal_bits = draco_normal_bits(mesh.normals, scale, config.tolerance_deg);
    }
    if (scale[0] != scale[2]) mesh.normals = scaled_normals(mesh.normals, scale);
    if (config.draco.texcoord_bits > 0) {
        quantisation.texcoord_bits = config.draco.texcoord_bits;
    } else if (!mesh.texcoords.empty()) {
        quantisation.texcoords = quantise_texcoords(mesh.texcoords, textured.width_px, textured.height_px,
                                                    config.tolerance_px, GridShape::cubic);
    }
    // Six decimals hold integer cell numbers, but not small steps.
    quantisation.exact_boxes = (is_on_grid && shape == GridShape::cubic) ||
                               !keeps_tolerance(plan, textured, camera, config.tolerance_px);
    if (quantisation.exact_boxes && !keeps_tolerance(plan, textured, camera, config.tolerance_px))
        throw Error(ErrorKind::output,
                    "Draco's 32-bit numbers cannot hold this mesh within export.tolerance_px; raise it, or "
                    "write it without Draco");
    return plan;
}

CompressedMesh compress_draco(const TexturedMesh& textured, const Calibration* camera,
                              const ExportConfig& config, GridShape shape, int threads) {
    DracoPlan plan;
    const auto find = [&] {
        plan = plan_draco(textured, camera, config, shape, threads);
        return DracoValues{&plan.mesh, &plan.quantisation};
    };
    DracoMesh draco = encode_draco(textured.mesh, config.draco.level, find, threads);
    return {std::move(draco), plan.transform};
}

}  // namespace hexrelief::exporters
