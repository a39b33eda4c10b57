#include "cuda/cuda_matcher.h"

#include <string>

#include "cuda/cuda_mesher.h"
#include "cuda/matching/match_pair.h"

namespace hexrelief::cuda {

struct CudaMatcher::State : cuda::DeviceMatcher {};

CudaMatcher::CudaMatcher() {
    std::string why;
    const std::vector<CudaDevice> devices = list_cuda_devices(&why);
    if (devices.empty()) throw Error(ErrorKind::device, "backend cuda: " + why + "; use --backend cpu");
    cuda::check(cudaSetDevice(devices.front().index), "choosing the device");
    state_ = std::make_unique<State>();
}

CudaMatcher::~CudaMatcher() = default;

std::size_t CudaMatcher::device_bytes() const {
    return state_->work.arena.peak_bytes();
}

matching::MatchedMap CudaMatcher::match_pair(const StereoPair& pair, const matching::MatchingConfig& config) {
    return state_->match_pair(pair, config);
}

}  // namespace hexrelief::cuda
