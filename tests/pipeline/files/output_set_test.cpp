// Tests that the files of a run are put in place together, or nothing changes.
#include "pipeline/files/output_set.h"

#include <gtest/gtest.h>

#include "pipeline/files/sha256.h"
#include "tests/pipeline/process.h"

namespace hexrelief::files {
namespace {

namespace fs = std::filesystem;

TEST(OutputSet, NothingIsThereBeforeItIsCommitted) {
    const test::TemporaryFolder folder;
    const fs::path mesh = folder / "new/deep/a.glb", report = folder / "r.json";
    test::write_text(report, "old");
    OutputSet set;
    set.place(mesh);
    set.files().write(mesh, std::string("mesh"));
    set.place(report);
    set.files().write(report, std::string("report"));
    EXPECT_FALSE(fs::exists(mesh));
    EXPECT_EQ(test::read_text(report), "old");
    set.commit();
    EXPECT_EQ(test::read_text(mesh), "mesh");
    EXPECT_EQ(test::read_text(report), "report");
    ASSERT_EQ(set.written().size(), 2u);
    EXPECT_EQ(set.written()[0].path, mesh);
    EXPECT_EQ(set.written()[0].bytes, 4u);
    EXPECT_EQ(set.written()[0].sha256, sha256_of_file(mesh));
}

TEST(OutputSet, WithoutCommitItsFoldersGo) {
    const test::TemporaryFolder folder;
    {
        OutputSet set;
        set.place(folder / "new/deep/a.glb");
        set.files().write(folder / "new/deep/a.glb", std::string("mesh"));
    }
    EXPECT_EQ(folder.entries(), 0);
}

// The first set made the folder; the second one needs it.
TEST(OutputSet, AFolderStaysForTheOtherSet) {
    const test::TemporaryFolder folder;
    const fs::path path = folder / "new/b.glb";
    OutputSet second;
    {
        OutputSet first;
        first.place(folder / "new/a.glb");
        second.place(path);
    }
    second.files().write(path, std::string("mesh"));
    second.commit();
    EXPECT_TRUE(fs::exists(path));
}

}  // namespace
}  // namespace hexrelief::files
