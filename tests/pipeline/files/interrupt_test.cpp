// Tests that Ctrl-C and termination leave nothing behind.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "tests/pipeline/process.h"

namespace hexrelief::files {
namespace {

using namespace test;

// Long enough to be interrupted at work: a fine lattice and many iterations.
std::vector<std::string> long_job(const TemporaryFolder& folder) {
    return pair_arguments({"-o", folder / "a.glb", "-o", folder / "a.obj", "--report", folder / "r.json",
                           "--save-stages", folder / "stages", "--set", "mesh.spacing_px=2", "--set",
                           "mesh.t_max=100000"});
}

// True if the process has a handler of its own for the signal.
bool catches(pid_t process, int signal) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("SigCgt:")) return std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1;
    return false;
}

class Interrupt : public testing::TestWithParam<int> {};

TEST_P(Interrupt, EndsTheLongStageAtOnceWithoutFiles) {
    const TemporaryFolder folder;
    const pid_t process = start_program(long_job(folder));
    // A busy machine may start the program slowly; without a handler the signal would just end it.
    for (int tries = 0; tries < 1000 && !catches(process, GetParam()); ++tries)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    const auto begun = std::chrono::steady_clock::now();
    kill(process, GetParam());
    EXPECT_EQ(wait_for_exit(process), 130);
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(2));
    EXPECT_EQ(folder.entries(), 0);
}

INSTANTIATE_TEST_SUITE_P(Signals, Interrupt, testing::Values(SIGINT, SIGTERM));

// Whenever the signal comes, all files are there or none.
TEST(InterruptAnyTime, LeavesAllFilesOrNone) {
    constexpr std::ptrdiff_t kAll = 5 + 11;  // glb, obj, mtl, texture, report; the folder and its ten
    int interrupted = 0;
    for (int delay_ms = 20; delay_ms <= 1200; delay_ms += 60) {
        const TemporaryFolder folder;
        const pid_t process =
            start_program(pair_arguments({"-o", folder / "a.glb", "-o", folder / "a.obj", "--report",
                                          folder / "r.json", "--save-stages", folder / "stages"}));
        std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
        kill(process, SIGINT);
        const int code = wait_for_exit(process);
        if (code == 0) {
            EXPECT_EQ(folder.entries(), kAll) << delay_ms;
        } else {
            // Before the program has installed its handlers, a signal ends it in the default way.
            EXPECT_TRUE(code == 130 || code == -SIGINT) << code;
            // After the last file is in place, an interrupt ends the process but undoes nothing.
            EXPECT_TRUE(folder.entries() == 0 || folder.entries() == kAll)
                << delay_ms << " " << folder.entries();
            ++interrupted;
        }
    }
    EXPECT_GT(interrupted, 0);
}

}  // namespace
}  // namespace hexrelief::files
