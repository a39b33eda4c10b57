#include "mesher/surface/fit/corner_lanes.h"

#include <cstring>
#include <limits>

#include "mesher/common/simd.h"

namespace hexrelief {
namespace {

constexpr int K = CornerLanes::kLanes;

typedef double Lanes __attribute__((vector_size(8 * K)));

HEXRELIEF_VECTORS void find_worst(const double (*from)[K], const double (*to)[K], double least,
                                  double* spare) {
    Lanes corners[2][6];
    std::memcpy(corners[0], from, sizeof corners[0]);
    std::memcpy(corners[1], to, sizeof corners[1]);
    Lanes worst = Lanes{} + std::numeric_limits<double>::max();
    HEXRELIEF_UNROLL
    for (unsigned gone = 1; gone < 8; ++gone) {
        const Lanes* const a = &corners[gone & 1u][0];
        const Lanes* const b = &corners[gone >> 1 & 1u][2];
        const Lanes* const c = &corners[gone >> 2][4];
        const step::SizeOf<Lanes> size = step::size_between(a[0], a[1], b[0], b[1], c[0], c[1]);
        const Lanes own = step::kShapeScale * size.area2 - least * size.sides2;  // see step::is_thin()
        worst = own < worst ? own : worst;
    }
    std::memcpy(spare, &worst, sizeof worst);
}

}  // namespace

void CornerLanes::find_spare(double least, double* spare) const {
    find_worst(from_, to_, least, spare);
}

}  // namespace hexrelief
