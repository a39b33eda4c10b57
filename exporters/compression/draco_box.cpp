#include "exporters/compression/draco_box.h"

#include <draco/compression/expert_encode.h>
#include <draco/core/quantization_utils.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "pipeline/data/number_text.h"

namespace hexrelief::exporters {
namespace {

float in_six_decimals(float value) {
    return std::strtof(std::to_string(value).c_str(), nullptr);
}

// The values that a decoder returns for a grid's values.
template <int N>
class Decoded {
  public:
    Decoded(const Grid<N>& grid, bool exactly) : grid_(grid), box_(box_of(grid, exactly)) {
        const auto most = static_cast<std::int32_t>((1u << box_.bits) - 1);
        is_box_ = std::isnormal(box_.range) && std::isnormal(static_cast<float>(most) / box_.range) &&
                  decoder_.Init(box_.range, most);
        if (is_box_) encoder_.Init(box_.range, most);
    }
    bool is_box() const { return is_box_; }
    float operator()(std::size_t vertex, int axis) const {
        const auto given = static_cast<float>(grid_.value(vertex, axis));
        return decoder_(encoder_(given - box_.origin[axis])) + box_.origin[axis];
    }

  private:
    const Grid<N>& grid_;
    DracoBox box_;
    bool is_box_;
    draco::Quantizer encoder_;
    draco::Dequantizer decoder_;
};

}  // namespace

template <int N>
DracoBox box_of(const Grid<N>& grid, bool exactly) {
    DracoBox box{grid.bits(), {}, 0};
    std::copy(grid.origin.begin(), grid.origin.end(), box.origin.begin());
    box.range = static_cast<float>(grid.step[0] * ((1u << box.bits) - 1));
    if (exactly) return box;
    for (float& origin : box.origin) origin = in_six_decimals(origin);
    box.range = in_six_decimals(box.range);
    return box;
}
template DracoBox box_of(const Grid<2>&, bool);
template DracoBox box_of(const Grid<3>&, bool);

template <int N>
void set_box(draco::ExpertEncoder& encoder, int attribute, const Grid<N>& grid, bool exactly) {
    const DracoBox box = box_of(grid, true);
    encoder.SetAttributeExplicitQuantization(attribute, box.bits, N, box.origin.data(), box.range);
    if (!exactly) return;
    draco::Options options = *encoder.options().FindAttributeOptions(attribute);
    std::string origin;
    for (int axis = 0; axis < N; ++axis) origin += number_text(box.origin[axis]) + " ";
    options.SetString("quantization_origin", origin);
    options.SetString("quantization_range", number_text(box.range));
    encoder.options().SetAttributeOptions(attribute, options);
}
template void set_box(draco::ExpertEncoder&, int, const Grid<2>&, bool);
template void set_box(draco::ExpertEncoder&, int, const Grid<3>&, bool);

double position_error_px(const SurfaceMesh& mesh, const Calibration& camera, const Grid<3>& grid,
                         const FileTransform& transform, bool exactly) {
    const Decoded<3> decoded(grid, exactly);
    if (!decoded.is_box()) return INFINITY;
    double worst = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const auto in_space = [&](int axis) { return decoded(i, axis) * transform.scale[axis]; };
        const Vec3f& p = mesh.positions[i];
        const double x = in_space(0), y = in_space(1), z = in_space(2);
        const double error =
            std::max({std::abs(x / z - double(p.x) / p.z), std::abs(y / z - double(p.y) / p.z),
                      camera.baseline_m * std::abs(1 / z - 1 / double(p.z))});
        if (!(error <= worst)) worst = error;
        if (std::isnan(worst)) break;
    }
    return worst * camera.focal_px;
}

double texcoord_error_px(const std::vector<Vec2f>& texcoords, int width, int height, const Grid<2>& grid,
                         bool exactly) {
    const Decoded<2> decoded(grid, exactly);
    if (!decoded.is_box()) return INFINITY;
    double worst = 0;
    for (std::size_t i = 0; i < texcoords.size(); ++i)
        worst = std::max({worst, std::abs(double(decoded(i, 0)) - texcoords[i].x) * width,
                          std::abs(double(decoded(i, 1)) - texcoords[i].y) * height});
    return worst;
}

}  // namespace hexrelief::exporters
