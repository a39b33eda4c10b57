#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/remove_speckles.h"
#include "pipeline/matching/refine/consistency_step.h"

namespace hexrelief::cuda {
namespace {

enum class Task { begin, join, count, clear };

template <Task kTask>
__global__ void visit_patches(step::Patches patches, matching::DisparityOut map) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    if constexpr (kTask == Task::begin) patches.begin(at.x, at.y);
    if constexpr (kTask == Task::join) patches.join(at.x, at.y);
    if constexpr (kTask == Task::count) patches.count(at.x, at.y);
    if constexpr (kTask == Task::clear)
        if (patches.is_speckle(at.x, at.y)) map.at(at.x, at.y) = matching::kUnknown16;
}

}  // namespace

void remove_speckles(cudaStream_t stream, const matching::ConsistencyConfig& config,
                     const SpeckleArrays& arrays, const matching::DisparityOut& map) {
    const step::Patches patches{reading(map), config, arrays.parents, arrays.sizes};
    const auto visit = [&](auto kernel) {
        launch("removing speckles", stream, pixel_blocks(map.width, map.height), kernel, patches, map);
    };
    visit(visit_patches<Task::begin>);
    visit(visit_patches<Task::join>);
    visit(visit_patches<Task::count>);
    visit(visit_patches<Task::clear>);
}

}  // namespace hexrelief::cuda
