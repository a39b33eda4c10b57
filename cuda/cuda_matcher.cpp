#include "cuda/cuda_matcher.h"

#include <string>

#include "cuda/common/arena.h"
#include "cuda/common/check.h"
#include "cuda/common/staging.h"
#include "cuda/cuda_mesher.h"
#include "cuda/matching/match_pair.h"

namespace hexrelief {

struct CudaMatcher::State {
    cudaStream_t stream = nullptr;
    cuda::Arena arena;
    cuda::Staging staging;
    cuda::StageClock clock;

    ~State() {
        if (stream) cudaStreamDestroy(stream);
    }
};

CudaMatcher::CudaMatcher() : state_(std::make_unique<State>()) {
    std::string why;
    const std::vector<CudaDevice> devices = list_cuda_devices(&why);
    if (devices.empty()) throw Error(ErrorKind::device, "backend cuda: " + why + "; use --backend cpu");
    cuda::check(cudaSetDevice(devices.front().index), "choosing the device");
    cuda::check(cudaStreamCreateWithFlags(&state_->stream, cudaStreamNonBlocking), "creating a stream");
}

CudaMatcher::~CudaMatcher() = default;

std::size_t CudaMatcher::device_bytes() const {
    return state_->arena.peak_bytes();
}

MatchedMap CudaMatcher::match_pair(const StereoPair& pair, const MatchingConfig& config,
                                   std::vector<CudaMatchingTime>* times) {
    state_->clock.enable(times != nullptr);
    MatchedMap map =
        cuda::match_pair(state_->stream, state_->arena, state_->staging, state_->clock, pair, config);
    if (times) {
        times->clear();
        for (const cuda::StageClock::Stage& stage : state_->clock.stages())
            times->push_back({stage.name, stage.seconds});
    }
    return map;
}

}  // namespace hexrelief
