#include "exporters/core/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>

#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;

// Ends as commit() would, killed after the first of two renames.
void kill_between_renames(const fs::path& folder) {
    const pid_t child = fork();
    if (child == 0) {
        const std::atomic<bool> never{false};
        const FolderLock::Renames renames = {{".hexrelief-1-0.tmp", "a"}, {".hexrelief-1-1.tmp", "b"}};
        for (const auto& [from, to] : renames) put(folder / from, "new");
        FolderLock lock(folder, never);
        lock.announce(renames);
        fs::rename(folder / renames[0].first, folder / renames[0].second);
        raise(SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
}

TEST(FolderLock, ASetKilledBetweenItsRenamesIsFinishedByTheNextRun) {
    const TemporaryFolder folder;
    for (const char* name : {"a", "b"}) put(folder / name, "old");
    kill_between_renames(folder / "");
    EXPECT_EQ(contents(folder / "a") + contents(folder / "b"), "newold");
    FileTransaction files;
    files.write(folder / "c", std::string("other"));
    EXPECT_EQ(contents(folder / "a") + contents(folder / "b"), "newnew");
    files.commit();
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / ""), {}), 3) << "leftovers";
}

TEST(FolderLock, AnnouncedRenamesAreOfWholeListsAndOfTheFolderAlone) {
    const std::atomic<bool> never{false};
    for (const std::string& list :
         {std::string(".hexrelief-1-0.tmp\0b\0", 21), std::string(".hexrelief-1-0.tmp\0../b\0\0", 25),
          std::string("a\0b\0\0", 5), std::string("\0\0", 2), std::string(".hexrelief-1-0.tmp\0\0\0", 21)}) {
        const TemporaryFolder folder;
        fs::create_directory(folder / "in");
        put(folder / "in/.hexrelief-1-0.tmp", "new");
        put(folder / "in/a", "new");
        put(folder / "in/.hexrelief-lock.tmp", list);
        const FolderLock lock(folder / "in", never);
        EXPECT_FALSE(fs::exists(folder / "in/b") || fs::exists(folder / "b"));
        EXPECT_EQ(contents(folder / "in/a"), "new");
    }
}

constexpr uid_t kOther = 65534;
const std::string kPlanted(".hexrelief-1-0.tmp\0b\0\0", 22);

// What a run that takes the lock of `folder` makes of b, which another user has planted a list of renames
// for.
std::string b_after_planting(const fs::path& folder, mode_t mode_of_lock,
                             const std::function<void()>& change) {
    const std::atomic<bool> never{false};
    put(folder / ".hexrelief-1-0.tmp", "planted");
    put(folder / "b", "old");
    put(folder / ".hexrelief-lock.tmp", kPlanted);
    EXPECT_EQ(::chmod((folder / ".hexrelief-lock.tmp").c_str(), mode_of_lock), 0);
    change();
    { const FolderLock lock(folder, never); }
    return contents(folder / "b");
}

void expect_lists_believed_in_folders_of_the_caller_alone() {
    struct Case {
        mode_t folder, lock;
        const char* b;
    };
    for (const Case& tried : {Case{0755, 0644, "planted"}, Case{0700, 0600, "planted"},
                              Case{01777, 0644, "old"}, Case{0777, 0644, "old"}, Case{03777, 0644, "old"},
                              Case{02775, 0644, "old"}, Case{0755, 0666, "old"}, Case{0755, 0664, "old"}}) {
        const TemporaryFolder folder;
        const auto change = [&] { EXPECT_EQ(::chmod(folder.path().c_str(), tried.folder), 0); };
        EXPECT_EQ(b_after_planting(folder.path(), tried.lock, change), tried.b)
            << std::oct << tried.folder << " " << tried.lock;
    }
    const TemporaryFolder folder;
    const auto link = [&] { fs::create_hard_link(folder / ".hexrelief-lock.tmp", folder / "kept"); };
    EXPECT_EQ(b_after_planting(folder.path(), 0644, link), "old") << "a link is elsewhere";
}

// Calls it in a child that is another user. False where the system does not let this one be another.
bool passes_as_other_user(const std::function<void()>& call) {
    const pid_t child = fork();
    if (child == 0) {
        if (::setgid(kOther) != 0 || ::setuid(kOther) != 0) std::_Exit(77);
        call();
        std::_Exit(testing::Test::HasFailure() ? 1 : 0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 77) return false;
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    return true;
}

TEST(FolderLock, ListsOfRenamesAreBelievedInFoldersOfTheCallerAlone) {
    expect_lists_believed_in_folders_of_the_caller_alone();
}

TEST(FolderLock, SoTheyAreByAPlainUser) {
    if (::geteuid() != 0 || !passes_as_other_user(expect_lists_believed_in_folders_of_the_caller_alone))
        GTEST_SKIP() << "NOTE: the user cannot be switched here: only the present one is tested";
}

TEST(FolderLock, RootBelievesNoListInAnotherUsersFolder) {
    if (::geteuid() != 0) GTEST_SKIP() << "NOTE: not root: folders of other users are not tested";
    const TemporaryFolder folder;
    const auto give = [&] { EXPECT_EQ(::chown(folder.path().c_str(), kOther, kOther), 0); };
    EXPECT_EQ(b_after_planting(folder.path(), 0644, give), "old");
}

// The lock is taken in a folder that all may write to, without a mask, between two runs of root.
TEST(FolderLock, NobodyElseCanPlantRenames) {
    const TemporaryFolder folder;
    const fs::path shared = folder / "shared", lock = shared / ".hexrelief-lock.tmp", kept = folder / "kept";
    fs::create_directory(shared);
    ASSERT_EQ(::chmod(shared.c_str(), 01777), 0);
    ASSERT_EQ(::chmod(folder.path().c_str(), 0777), 0);
    put(shared / "b", "old");
    const std::atomic<bool> never{false};
    const mode_t mask = ::umask(0);
    bool has_tried = false;
    std::error_code code;  // whether a link may be made depends on the system
    {
        const FolderLock held(shared, never);
        has_tried = ::geteuid() == 0 && passes_as_other_user([&] {
                        EXPECT_LT(::open(lock.c_str(), O_WRONLY), 0) << "the lock can be written to";
                        fs::create_hard_link(lock, kept, code);
                    });
    }
    ::umask(mask);
    if (!has_tried) GTEST_SKIP() << "NOTE: the user cannot be switched here: nobody tries to plant renames";
    passes_as_other_user([&] {
        put(shared / ".hexrelief-1-0.tmp", "planted");
        fs::rename(kept, lock, code);
        put(lock, kPlanted);
    });
    { const FolderLock next(shared, never); }
    EXPECT_EQ(contents(shared / "b"), "old");
}

TEST(FolderLock, AnotherUserIsNotWaitedForWithoutEnd) {
    const TemporaryFolder folder;
    const fs::path path = folder / temporary_name("lock");
    put(path, "");
    const int held = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_EQ(::flock(held, LOCK_EX | LOCK_NB), 0);
    if (::geteuid() != 0 || ::chown(path.c_str(), 65534, 65534) != 0) {
        ::close(held);
        GTEST_SKIP() << "only root can make a file of another user";
    }
    const std::atomic<bool> never{false};
    const auto begun = std::chrono::steady_clock::now();
    { const FolderLock lock(folder.path(), never); }
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30));
    EXPECT_TRUE(fs::exists(path)) << "a lock that was not taken is not removed";
    ::close(held);
}

}  // namespace
}  // namespace hexrelief::exporters
