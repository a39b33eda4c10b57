// What becomes of old files if renames fail, and go on failing.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "exporters/core/file_transaction.h"
#include "exporters/core/folder_lock.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace {
int renames_left = -1;  // below 0: any number
}

// Takes the place of the C library's in this program.
extern "C" int rename(const char* from, const char* to) noexcept {
    if (renames_left == 0) {
        errno = EIO;
        return -1;
    }
    if (renames_left > 0) --renames_left;
    return ::renameat(AT_FDCWD, from, AT_FDCWD, to);
}

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;

TEST(FailingRenames, OldFilesComeBackWithoutARename) {
    const TemporaryFolder folder;
    for (const char* name : {"a", "b", "c"}) put(folder / name, std::string("old ") + name);
    FileTransaction files;
    for (const char* name : {"a", "b", "c"}) files.write(folder / name, std::string("new"));
    renames_left = 2;
    EXPECT_THROW(files.commit(), Error);
    renames_left = -1;
    for (const char* name : {"a", "b", "c"}) EXPECT_EQ(contents(folder / name), std::string("old ") + name);
    EXPECT_EQ(folder.entries(), 3);
}

TEST(FailingRenames, TheOnlyCopyOfAnOldFileIsNoLeftover) {
    const TemporaryFolder folder;
    const fs::path kept = folder / ".hexrelief-1-0.old.tmp";
    put(kept, "old");
    put(folder / ".hexrelief-1-1.old.tmp", "killed while it renamed");
    keep_old(kept);
    FileTransaction files;
    files.write(folder / "a", std::string("new"));
    files.commit();
    EXPECT_EQ(contents(kept), "old");
    EXPECT_EQ(folder.entries(), 2);
}

// Without the sticky bit's rule the old file's link would stay, for its owner alone may remove it.
TEST(FailingRenames, AnotherUsersFileInAStickyFolderGetsNoLink) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root may become another user";
    constexpr uid_t other = 65534;
    const TemporaryFolder folder;
    fs::permissions(folder.path(), fs::perms(01777));
    put(folder / "a", "old");
    fs::permissions(folder / "a", fs::perms(0666));
    ASSERT_EQ(::seteuid(other), 0);
    FileTransaction files;
    files.write(folder / "a", std::string("new"));
    EXPECT_THROW(files.commit(), Error);
    ASSERT_EQ(::seteuid(0), 0);
    EXPECT_EQ(contents(folder / "a"), "old");
    EXPECT_EQ(folder.entries(), 1);
}

}  // namespace
}  // namespace hexrelief::exporters
