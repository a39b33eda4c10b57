#include "pipeline/job/backend.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/expect_error.h"

namespace hexrelief::job {
namespace {

TEST(Backend, CpuIsAlwaysThere) {
    const BackendPointer backend = pick_backend(config::BackendChoice::cpu, 1);
    EXPECT_EQ(backend->name(), "cpu");
    EXPECT_EQ(backend->threads(), 1);
    EXPECT_FALSE(backend->device().empty());
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
    const auto pick = [] { pick_backend(config::BackendChoice::cuda, 1, MeshMethod::cellular); };
    EXPECT_CONTAINS(test::error_of(pick, ErrorKind::device), "built without CUDA");
    EXPECT_EQ(pick_backend(config::BackendChoice::automatic, 1, MeshMethod::cellular)->name(), "cpu");
}
#endif

TEST(Backend, AutoTakesTheCpuForWhatOnlyItCanDo) {
    EXPECT_EQ(pick_backend(config::BackendChoice::automatic, 1, MeshMethod::sequential)->name(), "cpu");
}

TEST(Backend, KeptOnesAreThoseOfTheSameRequest) {
    Backends backends;
    const BackendPointer first = backends.get(config::BackendChoice::cpu, 1);
    EXPECT_EQ(first->name(), "cpu");
    EXPECT_EQ(backends.get(config::BackendChoice::cpu, 1), first);
    EXPECT_NE(backends.get(config::BackendChoice::cpu, 2, MeshMethod::sequential), first);
    EXPECT_FALSE(backends.ends_with_run());
}

}  // namespace
}  // namespace hexrelief::job
