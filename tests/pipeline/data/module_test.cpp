// Tests that modules are opened from the right folders only.
#include "pipeline/data/module.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

TEST(Module, OfABuildLiesInItsRoot) {
    const fs::path build = HEXRELIEF_BUILD_FOLDER;
    EXPECT_EQ(module_folder(build), build);
    EXPECT_EQ(module_folder(build / "tests" / "pipeline"), build);
    EXPECT_EQ(module_folder(own_object().parent_path()), build) << "this test's own";
    EXPECT_EQ(module_folder(build.string() + "-of-others"), "");
    EXPECT_EQ(module_folder(build.parent_path()), "");
}

TEST(Module, OfAnInstallationLiesBelowItsPrefix) {
    const fs::path program = HEXRELIEF_PROGRAM_FOLDER, library = HEXRELIEF_LIBRARY_FOLDER;
    EXPECT_EQ(module_folder("/usr" / program), "/usr/lib/hexrelief");
    EXPECT_EQ(module_folder("/opt/hexrelief" / library), "/opt/hexrelief/lib/hexrelief");
    EXPECT_EQ(module_folder("/usr/lib/python3/dist-packages/hexrelief"), "/usr/lib/hexrelief");
    EXPECT_EQ(module_folder("/usr/local/lib/python3.11/dist-packages/hexrelief"), "/usr/local/lib/hexrelief");
    for (const char* const elsewhere : {"/tmp", "/tmp/hexrelief", "/", "", "/usr/lib/python3/dist-packages"})
        EXPECT_EQ(module_folder(elsewhere), "") << elsewhere;
}

TEST(Module, OfAnotherOwnerIsRefused) {
    const fs::path file = fs::path(testing::TempDir()) / ("module-" + std::to_string(getpid()));
    std::ofstream(file) << "x";
    EXPECT_TRUE(is_trusted(file, file));
    EXPECT_FALSE(is_trusted(file, file.string() + "-missing"));
    fs::permissions(file, fs::perms::others_write, fs::perm_options::add);
    EXPECT_FALSE(is_trusted(file, file)) << "anybody may write to it";
    fs::permissions(file, fs::perms::others_write, fs::perm_options::remove);
    EXPECT_TRUE(is_trusted("/proc/self/exe", "/usr/bin/env") || getuid() != 0);
    if (getuid() == 0 && chown(file.c_str(), 12345, 12345) == 0) {
        EXPECT_FALSE(is_trusted(file, "/usr/bin/env"));
    }
    fs::remove(file);
}

TEST(Module, SaysWhyThereIsNone) {
    const ModuleFunction none = open_module("hexrelief-none.so", "f");
    EXPECT_EQ(none.function, nullptr);
    EXPECT_EQ(none.failure, "hexrelief-none.so is not in " HEXRELIEF_BUILD_FOLDER);
}

}  // namespace
}  // namespace hexrelief
