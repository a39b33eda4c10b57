// The built program: the files of users that it leaves alone, and their names as it prints them.
#include <gtest/gtest.h>

#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

TEST(Files, AnOutputIsNeverAnInput) {
    const TemporaryFolder folder;
    std::filesystem::copy_file(sample("left.png"), folder / "scene_texture.jpg");
    std::filesystem::create_symlink(sample("right.png"), folder / "link.png");
    expect_failure({"run", "--left", folder / "scene_texture.jpg", "--right", folder / "link.png", "-o",
                    folder / "scene.obj"},
                   2, "overwrite the input");
    expect_failure({"run", "--left", sample("left.png"), "--right", sample("right.png"), "-o",
                    folder / "a.glb", "--report", sample("left.png")},
                   2, "overwrite the input");
    const std::string manifest = "disparity\n" + sample("disparity.pfm") + "\n";
    write_text(folder / "batch.csv", manifest);
    expect_failure({"batch", folder / "batch.csv", "-o", folder.path().string()}, 2, "overwrite the input");
    EXPECT_EQ(read_text(folder / "batch.csv"), manifest);
    write_text(folder / "config.yaml", "mesh:\n  spacing_px: 6\n");
    expect_failure({"tiles", "plan", sample("disparity.pfm"), "--config", folder / "config.yaml", "-o",
                    folder.path().string()},
                   2, "overwrite the input");
    EXPECT_EQ(read_text(folder / "config.yaml"), "mesh:\n  spacing_px: 6\n");
}

TEST(Files, ADemoLeavesOthersFilesAlone) {
    const TemporaryFolder folder;
    const std::vector<std::string> demo = {"demo", "--no-open", folder / "a b"};
    const ProcessResult first = expect_success(demo);
    EXPECT_CONTAINS(first.out, "--left '" + (folder / "a b/left.png'"));
    EXPECT_EQ(run_program(demo).exit_code, 0) << "its own are written anew";
    write_text(folder / "a b/left.png", "mine");
    expect_failure(demo, 4, "left.png is there already");
    EXPECT_EQ(read_text(folder / "a b/left.png"), "mine");
    write_text(folder / "relief.glb", "mine");
    expect_failure({"demo", "--no-open", folder.path().string()}, 4, "relief.glb is there already");
}

TEST(Files, NamesDoNotSteerTheTerminal) {
    const TemporaryFolder folder;
    const std::string steering = "\x1b]0;title\a";
    write_text(folder / "pairs.csv", "disparity\nno" + steering + ".pfm\n");
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"batch", folder / "pairs.csv", "-o", folder / "out"},
          {"batch", folder / "pairs.csv", "-o", folder / "out", "--dry-run", "--log=text"},
          {"tiles", "plan", folder / (steering + ".pfm"), "-o", folder / "plan"},
          {"demo", "--no-open", folder / steering}}) {
        const ProcessResult result = run_program(arguments);
        EXPECT_EQ((result.out + result.err).find('\x1b'), std::string::npos) << arguments[0] << result.err;
    }
}

}  // namespace
}  // namespace hexrelief::cli
