#include "exporters/core/file_transaction.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <functional>
#include <thread>

#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;

std::string output_error(const std::function<void()>& call) {
    return test::error_of(call, ErrorKind::output);
}

TEST(FileTransaction, FilesAppearAtCommit) {
    const TemporaryFolder folder;
    FileTransaction files;
    files.write(folder / "a", std::string("one"));
    files.write(folder / "b", std::vector<std::uint8_t>{});
    EXPECT_FALSE(fs::exists(folder / "a"));
    files.commit();
    EXPECT_EQ(contents(folder / "a"), "one");
    EXPECT_EQ(contents(folder / "b"), "");
    EXPECT_EQ(folder.entries(), 2);
    const std::vector<fs::path> paths = {folder / "a", folder / "b"};
    EXPECT_EQ(files.paths(), paths);
}

TEST(FileTransaction, WithoutCommitNothingIsLeftAndOldFilesStay) {
    const TemporaryFolder folder;
    put(folder / "a", "old");
    {
        FileTransaction files;
        files.write(folder / "a", std::string("new"));
        files.write(folder / "b", std::string("new"));
    }
    EXPECT_EQ(contents(folder / "a"), "old");
    EXPECT_EQ(folder.entries(), 1);
}

TEST(FileTransaction, FilesWrittenPartByPartAppearAtCommit) {
    const TemporaryFolder folder;
    put(folder / "a", "old");
    FileTransaction files;
    const int descriptor = files.open(folder / "a");
    EXPECT_EQ(::write(descriptor, "one", 3), 3);
    files.write(folder / "b", std::string("b"));
    EXPECT_EQ(::pwrite(descriptor, "two", 3, 3), 3);
    EXPECT_EQ(contents(folder / "a"), "old");
    files.commit();
    EXPECT_EQ(contents(folder / "a"), "onetwo");
    const std::vector<fs::path> paths = {folder / "a", folder / "b"};
    EXPECT_EQ(files.paths(), paths);
    EXPECT_CONTAINS(output_error([&] { files.open("/dev/null"); }), "no regular file");
}

TEST(FileTransaction, KeepsPermissionsAndFollowsLinks) {
    const TemporaryFolder folder;
    put(folder / "a", "old");
    ::chmod((folder / "a").c_str(), 0640);
    fs::create_symlink("a", folder / "link");
    FileTransaction files;
    files.write(folder / "link", std::string("new"));
    files.commit();
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_EQ(contents(folder / "a"), "new");
    EXPECT_EQ(fs::status(folder / "a").permissions(), fs::perms(0640));
}

TEST(FileTransaction, NamesAsLongAsTheFileSystemAllows) {
    const TemporaryFolder folder;
    FileTransaction files;
    files.write(folder / std::string(255, 'x'), std::string("new"));
    files.commit();
    EXPECT_EQ(folder.entries(), 1);
    EXPECT_NE(output_error([&] {
                  files.write(folder / std::string(256, 'x'), std::string("new"));
                  files.commit();
              }),
              "");
    EXPECT_EQ(folder.entries(), 1);
}

TEST(FileTransaction, FolderInTheWayIsError) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "a");
    FileTransaction files;
    const std::string message = output_error([&] { files.write(folder / "a", std::string("new")); });
    EXPECT_CONTAINS(message, (folder / "a").string());
    EXPECT_CONTAINS(message, std::strerror(EISDIR));
}

TEST(FileTransaction, FolderAppearingBeforeCommitUndoesTheOthers) {
    const TemporaryFolder folder;
    FileTransaction files;
    files.write(folder / "a", std::string("new"));
    files.write(folder / "b", std::string("new"));
    fs::create_directory(folder / "b");
    output_error([&] { files.commit(); });
    EXPECT_FALSE(fs::exists(folder / "a"));
    EXPECT_EQ(folder.entries(), 1);
}

TEST(FileTransaction, OldFilesComeBackWhereARenameFails) {
    const TemporaryFolder folder;
    put(folder / "a", "old a");
    put(folder / "c", "old c");
    FileTransaction files;
    for (const char* name : {"a", "b", "c", "d"}) files.write(folder / name, std::string("new"));
    fs::create_directory(folder / "d");
    output_error([&] { files.commit(); });
    EXPECT_EQ(contents(folder / "a"), "old a");
    EXPECT_EQ(contents(folder / "c"), "old c");
    EXPECT_FALSE(fs::exists(folder / "b"));
    EXPECT_EQ(folder.entries(), 3);
}

TEST(FileTransaction, OneNameTwiceIsOneFile) {
    const TemporaryFolder folder;
    FileTransaction files;
    files.write(folder / "a", std::string("one"));
    files.write(folder / "a", std::string("two"));
    files.commit();
    EXPECT_EQ(contents(folder / "a"), "two");
    EXPECT_EQ(folder.entries(), 1);
}

TEST(FileTransaction, LeftoversGoButNotThoseOfTheLiving) {
    const TemporaryFolder folder;
    put(folder / ".hexrelief-1-0.tmp", "killed");
    put(folder / ".hexrelief-1-0.old.tmp", "killed while it renamed");
    put(folder / ".hexrelief-lock.tmp", "");
    put(folder / ".hexrelief.yaml", "another's");
    FileTransaction living;
    living.write(folder / "a", std::string("living"));
    EXPECT_EQ(folder.entries(), 2) << "the leftovers went before the first byte was written";
    {
        FileTransaction other;
        other.write(folder / "b", std::string("other"));
        other.commit();
    }
    living.commit();
    EXPECT_EQ(contents(folder / "a"), "living");
    EXPECT_EQ(contents(folder / ".hexrelief.yaml"), "another's");
    EXPECT_EQ(folder.entries(), 3);
}

TEST(FileTransaction, OfTwoSetsOfTheSameNamesOneIsThereWhole) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "sub");
    const auto write_sets = [&](const std::string& text) {
        for (int i = 0; i < 8; ++i) {
            FileTransaction files;
            for (const char* name : {"a", "sub/b", "c"}) files.write(folder / name, text);
            files.commit();
        }
    };
    for (int round = 0; round < 2; ++round) {
        std::thread other([&] { write_sets("other"); });
        write_sets("mine");
        other.join();
        EXPECT_EQ(contents(folder / "a"), contents(folder / "c"));
        EXPECT_EQ(contents(folder / "a"), contents(folder / "sub/b"));
    }
    EXPECT_EQ(folder.entries(), 4);
}

TEST(FileTransaction, ToldOfEachFile) {
    const TemporaryFolder folder;
    std::string told;
    FileTransaction files([&](const fs::path& path, const void* data, std::size_t bytes) {
        told += path.filename().string() + "=" + std::string(static_cast<const char*>(data), bytes) + " ";
    });
    files.write(folder / "a", std::string("one"));
    files.write("/dev/null", std::string("two"));
    EXPECT_EQ(told, "a=one null=two ");
}

TEST(FileTransaction, ReadOnlyFileSystem) {
    FileTransaction files;
    EXPECT_CONTAINS(output_error([&] { files.write("/proc/hexrelief", std::string("new")); }),
                    "/proc/hexrelief");
}

// Runs in a child that is not root, because permissions do not apply to root.
TEST(FileTransactionDeathTest, ReadOnlyFileAndFolder) {
    const TemporaryFolder folder;
    put(folder / "a", "old");
    fs::create_directory(folder / "closed");
    ::chmod(folder.path().c_str(), 0777);
    ::chmod((folder / "a").c_str(), 0444);
    ::chmod((folder / "closed").c_str(), 0555);
    const auto refused = [&] {
        if (::geteuid() == 0 && ::seteuid(65534) != 0) std::_Exit(2);
        FileTransaction files;
        for (const fs::path& path : {folder / "a", folder / "closed" / "b"}) {
            const std::string message = output_error([&] { files.write(path, std::string("new")); });
            EXPECT_CONTAINS(message, path.string());
            EXPECT_CONTAINS(message, std::strerror(EACCES));
        }
        std::_Exit(::testing::Test::HasFailure() ? 1 : 0);
    };
    EXPECT_EXIT(refused(), ::testing::ExitedWithCode(0), "");
    EXPECT_EQ(contents(folder / "a"), "old");
    EXPECT_EQ(folder.entries(), 2);
}

TEST(FileTransaction, DiskThatFillsUpLeavesNothing) {
    const TemporaryFolder folder;
    rlimit before = {};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit small = before;
    small.rlim_cur = 4096;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    std::string message;
    {
        FileTransaction files;
        files.write(folder / "fits", std::string("one"));
        message = output_error([&] { files.write(folder / "big", std::string(100000, 'x')); });
    }
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_CONTAINS(message, std::strerror(EFBIG));
    EXPECT_EQ(folder.entries(), 0);
}

TEST(FileTransaction, PipesAreWrittenTo) {
    const TemporaryFolder folder;
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    std::string received;
    std::thread reader([&] { received = contents(folder / "pipe"); });
    FileTransaction files;
    files.write(folder / "pipe", std::string("through"));
    files.commit();
    reader.join();
    EXPECT_EQ(received, "through");
    EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(FileTransactionDeathTest, InterruptRemovesTemporariesOfAllThreads) {
    const TemporaryFolder folder;
    const auto interrupted = [&] {
        std::signal(SIGINT, [](int) {
            remove_pending_files();
            std::_Exit(130);
        });
        FileTransaction mine;
        mine.write(folder / "a", std::string("one"));
        mine.write(folder / "b", std::string("two"));
        std::thread([&] {
            auto* others = new FileTransaction;  // never destroyed, as in a process that ends
            others->write(folder / "c", std::string("three"));
        }).join();
        if (folder.entries() != 3) std::_Exit(1);
        std::raise(SIGINT);
    };
    EXPECT_EXIT(interrupted(), ::testing::ExitedWithCode(130), "");
    EXPECT_EQ(folder.entries(), 0);
}

TEST(FileTransactionDeathTest, AfterRemovalNothingIsWrittenAnyMore) {
    const TemporaryFolder folder;
    const auto late = [&] {
        FileTransaction before;
        before.write(folder / "a", std::string("one"));
        remove_pending_files();
        output_error([&] { before.commit(); });
        FileTransaction after;
        output_error([&] { after.write(folder / "b", std::string("two")); });
        std::_Exit(::testing::Test::HasFailure() ? 1 : 0);
    };
    EXPECT_EXIT(late(), ::testing::ExitedWithCode(0), "");
    EXPECT_EQ(folder.entries(), 0);
}

TEST(FileTransactionDeathTest, InterruptAnyTimeLeavesAllFilesOrNone) {
    for (int round = 0; round < 20; ++round) {
        const TemporaryFolder folder;
        const auto busy = [&] {
            std::signal(SIGALRM, [](int) {
                remove_pending_files();
                std::_Exit(0);
            });
            ::ualarm(static_cast<useconds_t>(500 + 150 * round), 0);
            for (int i = 0;; ++i) {
                FileTransaction files;
                for (const char* part : {"a", "b", "c"})
                    files.write(folder / (std::to_string(i) + part), std::string(2000, 'x'));
                files.commit();
            }
        };
        EXPECT_EXIT(busy(), ::testing::ExitedWithCode(0), "");
        EXPECT_EQ(folder.entries() % 3, 0);
        for (const auto& entry : fs::directory_iterator(folder.path())) EXPECT_EQ(entry.file_size(), 2000u);
    }
}

TEST(FileTransactionDeathTest, InterruptOverOldFilesLeavesOneSet) {
    for (int round = 0; round < 20; ++round) {
        const TemporaryFolder folder;
        for (const char* name : {"a", "b", "c"}) put(folder / name, "old");
        const auto busy = [&] {
            std::signal(SIGALRM, [](int) {
                remove_pending_files();
                std::_Exit(0);
            });
            ::ualarm(static_cast<useconds_t>(1000 + 450 * round), 0);
            for (int i = 0;; ++i) {
                FileTransaction files;
                for (const char* name : {"a", "b", "c"}) files.write(folder / name, std::to_string(i));
                files.commit();
            }
        };
        EXPECT_EXIT(busy(), ::testing::ExitedWithCode(0), "");
        EXPECT_EQ(folder.entries(), 3);
        EXPECT_EQ(contents(folder / "a"), contents(folder / "b"));
        EXPECT_EQ(contents(folder / "a"), contents(folder / "c"));
    }
}

}  // namespace
}  // namespace hexrelief::exporters
