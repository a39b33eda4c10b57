// The resources that a matcher keeps from call to call.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/staging.h"
#include "cuda/matching/common/side_stream.h"
#include "cuda/matching/common/stage_clock.h"

namespace hexrelief::cuda {

struct Workspace {
    cudaStream_t stream = nullptr;
    SideStream side;
    Arena arena;
    Staging staging;
    StageClock clock;  // measures `stream`

    // Creates the streams on the current device.
    Workspace() { check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "creating a stream"); }
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;
    ~Workspace() { cudaStreamDestroy(stream); }
};

}  // namespace hexrelief::cuda
