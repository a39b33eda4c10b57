#include "cuda/cuda_mesher.h"

#include <utility>

#include "cuda/balance/balance.h"
#include "cuda/common/arena.h"
#include "cuda/common/check.h"
#include "cuda/common/resident_map.h"
#include "cuda/common/staging.h"
#include "cuda/mesh_job.h"
#include "cuda/surface/cut_disparity_mesh.h"

namespace hexrelief::cuda {

struct CudaMesher::State {
    CudaDevice device;
    bool can_cut_meshes = false;
    cuda::Launch launch{};
    cudaStream_t copies = nullptr;  // for the map, which is needed last
    cudaEvent_t begin = nullptr, end = nullptr, copied = nullptr;
    // of `magnification`, a table that is kept because computing it takes as long as a transfer
    double exponent = 1;
    std::vector<float> magnification;
    cuda::Arena arena;
    cuda::Staging staging;
    const DisparityMap* expected_map = nullptr;  // for the next solve(); null = none
    cuda::ResidentMap map;
    cuda::LevelTimer balance_timer;
    DeviceFigures figures;
};

CudaMesher::CudaMesher() : state_(std::make_unique<State>()) {
    std::string why;
    const std::vector<CudaDevice> devices = list_cuda_devices(&why);
    if (devices.empty()) throw Error(ErrorKind::device, "backend cuda: " + why + "; use --backend cpu");
    state_->device = devices.front();
    cuda::check(cudaSetDevice(state_->device.index), "choosing the device");
    cuda::check(cudaStreamCreateWithFlags(&state_->launch.stream, cudaStreamNonBlocking),
                "creating a stream");
    cuda::check(cudaEventCreate(&state_->begin), "creating an event");
    cuda::check(cudaEventCreate(&state_->end), "creating an event");
    cuda::check(cudaStreamCreateWithFlags(&state_->copies, cudaStreamNonBlocking), "creating a stream");
    cuda::check(cudaEventCreateWithFlags(&state_->copied, cudaEventDisableTiming), "creating an event");
    state_->launch.multiprocessors = state_->device.multiprocessors;
    const cuda::ClusterCapacity clusters = cuda::cluster_capacity();
    state_->launch.cluster_blocks = clusters.blocks;
    state_->launch.clusters = clusters.clusters;
    state_->can_cut_meshes = cuda::can_cut_meshes();
    state_->arena.take<char>(1);
    state_->arena.reset();
}

CudaMesher::~CudaMesher() {
    if (state_->end) cudaEventDestroy(state_->end);
    if (state_->begin) cudaEventDestroy(state_->begin);
    if (state_->copied) cudaEventDestroy(state_->copied);
    if (state_->copies) cudaStreamDestroy(state_->copies);
    if (state_->launch.stream) cudaStreamDestroy(state_->launch.stream);
}

const CudaDevice& CudaMesher::device() const {
    return state_->device;
}

bool CudaMesher::can_cut_meshes() const {
    return state_->can_cut_meshes;
}

DisparityMesh CudaMesher::cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                             const SurfaceConfig& config) {
    surface::check_disparity_mesh_input(input);
    const float* const map = state_->map.copy_of(input.map->values);
    DisparityMesh mesh = cuda::cut_disparity_mesh(state_->launch, state_->arena, state_->staging, map, input,
                                                  config, state_->figures.surface_s);
    state_->figures.bytes = state_->arena.peak_bytes() + (map ? state_->map.bytes() : 0);
    return mesh;
}

const DeviceFigures& CudaMesher::figures() const {
    return state_->figures;
}

void CudaMesher::balance_patch(const DensityMap& density, const BalanceConfig& config,
                               balance::LatticePatch& patch) {
    cuda::balance_patch(state_->launch, state_->arena, state_->staging, density, config, patch);
}

void CudaMesher::expect_map(const DisparityMap& map) {
    state_->expected_map = &map;
}

HexMesh2D CudaMesher::solve(const DensityMap& density, const MeshConfig& config,
                            const ProgressFunction& progress) {
    const DisparityMap* const map = std::exchange(state_->expected_map, nullptr);
    state_->map.forget();
    if (config.method == MeshMethod::sequential)
        throw Error(ErrorKind::usage,
                    "mesh.method: sequential has no CUDA form; use cellular, or --backend cpu");
    if (state_->exponent != config.magnification) {
        state_->magnification = som::magnification_table(config.magnification);
        state_->exponent = config.magnification;
    }
    const cudaStream_t stream = state_->launch.stream;
    cuda::MeshJob job(state_->launch, state_->arena, density, config, state_->magnification);
    float* const resident_map = map ? state_->map.make_room(map->values.size()) : nullptr;
    job.upload(state_->staging);
    cuda::check(cudaEventRecord(state_->begin, stream), "timing");
    job.build_pyramids();
    job.solve_levels(state_->balance_timer, progress);
    if (map) {  // the host copies while the device trains
        state_->staging.upload(state_->copies, resident_map, map->values.data(), map->values.size());
        cuda::check(cudaEventRecord(state_->copied, state_->copies), "uploading");
    }
    job.untangle();
    cuda::check(cudaEventRecord(state_->end, stream), "timing");
    job.move_to_area();
    if (map) {
        cuda::check(cudaStreamWaitEvent(stream, state_->copied), "uploading");
        state_->map.hold(map->values);
    }

    HexMesh2D mesh = job.download(state_->staging);
    mesh.iterations = job.iterations();
    float milliseconds = 0;
    cuda::check(cudaEventElapsedTime(&milliseconds, state_->begin, state_->end), "timing");
    DeviceFigures& figures = state_->figures;
    figures.balance_s = config.balance.enabled ? state_->balance_timer.seconds(job.levels()) : 0;
    figures.training_s = milliseconds * 1e-3 - figures.balance_s;
    figures.bytes = state_->arena.peak_bytes() + (map ? state_->map.bytes() : 0);
    return mesh;
}

}  // namespace hexrelief::cuda
