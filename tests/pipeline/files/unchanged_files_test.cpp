#include "pipeline/files/sha256.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "pipeline/data/error.h"
#include "tests/pipeline/process.h"

namespace hexrelief::files {
namespace {

namespace fs = std::filesystem;

TEST(UnchangedFiles, ToldWhereOneWasWrittenToOrReplaced) {
    const test::TemporaryFolder folder;
    const fs::path path = folder / "a";
    test::write_text(path, "old");
    const auto check = [&](const auto& change) {
        const UnchangedFiles files({path, folder / "missing"});
        files.check();
        change();
        EXPECT_THROW(files.check(), Error);
    };
    check([&] { test::write_text(path, "longer"); });
    check([&] { fs::last_write_time(path, fs::last_write_time(path) - std::chrono::hours(1)); });
    check([&] {
        fs::copy_file(path, folder / "b");
        fs::last_write_time(folder / "b", fs::last_write_time(path));
        fs::rename(folder / "b", path);
    });
    check([&] { fs::remove(path); });
}

TEST(UnchangedFiles, ATimeThatWasSetBackIsToldByThatOfTheAttributes) {
    const test::TemporaryFolder folder;
    const fs::path path = folder / "a";
    test::write_text(path, "old");
    const auto time = fs::last_write_time(path);
    const UnchangedFiles files({path});
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // a file system's clock may be coarse
    test::write_text(path, "new");
    fs::last_write_time(path, time);
    EXPECT_THROW(files.check(), Error);
}

}  // namespace
}  // namespace hexrelief::files
