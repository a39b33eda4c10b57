#include "pipeline/job/backend.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/data/error.h"

namespace hexrelief::job {
namespace {

TEST(Backend, CpuIsAlwaysThere) {
    const Backend backend = pick_backend(config::BackendChoice::cpu, 1, MeshMethod::cellular);
    EXPECT_EQ(backend.name, "cpu");
    EXPECT_FALSE(backend.device.empty());
    ASSERT_FALSE(list_devices().empty());
    EXPECT_EQ(list_devices().front().backend, "cpu");
}

TEST(Backend, ThreadsDefaultToAtLeastOne) {
    EXPECT_GE(effective_threads(0), 1);
    EXPECT_EQ(effective_threads(3), 3);
    EXPECT_LE(effective_threads(1024), std::max(8, effective_threads(0)));
}

#ifndef HEXRELIEF_HAS_CUDA
TEST(Backend, CudaIsADeviceErrorWhereItIsNotBuiltIn) {
    try {
        pick_backend(config::BackendChoice::cuda, 1, MeshMethod::cellular);
        FAIL() << "no error";
    } catch (const Error& e) {
        EXPECT_EQ(e.kind(), ErrorKind::device);
        EXPECT_NE(std::string(e.what()).find("built without CUDA"), std::string::npos);
    }
    EXPECT_EQ(pick_backend(config::BackendChoice::automatic, 1, MeshMethod::cellular).name, "cpu");
}
#endif

TEST(Backend, AutoTakesTheCpuForWhatOnlyItCanDo) {
    EXPECT_EQ(pick_backend(config::BackendChoice::automatic, 1, MeshMethod::sequential).name, "cpu");
}

TEST(Backend, KeptOnesAreThoseOfTheSameRequest) {
    const BackendPicker pick = keep_backends();
    EXPECT_EQ(pick(config::BackendChoice::cpu, 1, MeshMethod::cellular).name, "cpu");
    EXPECT_EQ(pick(config::BackendChoice::cpu, 1, MeshMethod::cellular).name, "cpu");
    EXPECT_EQ(pick(config::BackendChoice::cpu, 2, MeshMethod::sequential).name, "cpu");
}

}  // namespace
}  // namespace hexrelief::job
