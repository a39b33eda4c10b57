// Tests which pairs are found in folders, and by patterns.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "pipeline/batch/file_pattern.h"
#include "pipeline/batch/manifest.h"
#include "tests/pipeline/process.h"

namespace hexrelief::batch {
namespace {

using namespace test;
using Words = std::vector<std::string>;
namespace fs = std::filesystem;

const ManifestOptions kFolderOptions{
    .output = "out", .file_options = {"--left", "--right", "--stereo", "--disparity", "--depth"}};

void make_files(const TemporaryFolder& folder, const std::vector<std::string>& names) {
    for (const std::string& name : names) {
        fs::create_directories(fs::path(folder / name).parent_path());
        write_text(folder / name, "");
    }
}

// Returns a folder's units, as "name = files (rule's name)" or "name! what is wrong".
std::vector<std::string> found_in(const TemporaryFolder& folder) {
    const std::string top = folder / "";
    std::vector<std::string> units;
    for (const BatchUnit& unit : read_manifest(folder.path(), kFolderOptions)) {
        std::string text = unit.name + (unit.wrong.empty() ? " =" : "! " + unit.wrong);
        for (std::size_t i = 0; unit.wrong.empty() && i < unit.words.size(); ++i)
            if (unit.words[i].starts_with(top)) text += " " + unit.words[i].substr(top.size());
        const auto rule = unit.rule.find(" (");
        text += " (" + unit.rule.substr(0, rule) + ")";
        while (text.find(top) != std::string::npos) text.erase(text.find(top), top.size());
        units.push_back(text);
    }
    return units;
}

std::vector<std::string> found_in(const std::vector<std::string>& names) {
    const TemporaryFolder folder;
    make_files(folder, names);
    return found_in(folder);
}

TEST(FolderRows, FoldersGiveTheirPairs) {
    const TemporaryFolder folder;
    make_files(folder, {"b_left.png", "b_right.png", "a_left.jpg", "a_right.jpg", "a_calib.txt", "c_left.png",
                        "notes.txt"});
    const auto units = read_manifest(folder.path(), kFolderOptions);
    ASSERT_EQ(units.size(), 3u);
    EXPECT_EQ(units[0].name, "a");
    EXPECT_EQ(units[0].words,
              (Words{"--left", folder / "a_left.jpg", "--right", folder / "a_right.jpg", "--calib",
                     folder / "a_calib.txt", "-o", "out/a.glb", "--report", "out/a.json"}));
    EXPECT_EQ(units[1].wrong, "");
    EXPECT_CONTAINS(units[2].wrong, "right image is missing");
}

TEST(FolderRows, PatternsMayNameFolders) {
    const TemporaryFolder folder;
    for (const std::string name : {"one", "two"}) {
        std::filesystem::create_directory(folder / name);
        for (const char* const file : {"left.png", "right.png", "calib.txt"})
            write_text((folder / name) + "/" + file, "");
    }
    const auto units = read_manifest(folder / "{name}/left.png", kFolderOptions);
    ASSERT_EQ(units.size(), 2u);
    EXPECT_EQ(units[1].name, "two");
    EXPECT_EQ(units[1].words[3], folder / "two/right.png");
    EXPECT_EQ(units[1].words[5], folder / "two/calib.txt");
    EXPECT_THROW(read_manifest(folder / "{name}.png", kFolderOptions), Error);
    EXPECT_THROW(read_manifest(folder / "{name}_left.png", kFolderOptions), Error);
}

TEST(FolderRows, EachRuleFindsItsUnits) {
    struct Example {
        std::vector<std::string> files;
        std::string unit;
    };
    const std::vector<Example> examples = {
        {{"a_sbs.jpg"}, "a = a_sbs.jpg (side by side)"},
        {{"a-side-by-side.png"}, "a = a-side-by-side.png (side by side, in words)"},
        {{"a.left-right.jpg"}, "a = a.left-right.jpg (left and right in one)"},
        {{"a_over-under.jpg"}, "a = a_over-under.jpg (left over right)"},
        {{"s/left.png", "s/right.png", "s/calib.yaml"},
         "s = s/left.png s/right.png s/calib.yaml (left and right)"},
        {{"teddy/im2.ppm", "teddy/im6.ppm", "teddy/im0.ppm", "teddy/im1.ppm", "teddy/disp2.pgm"},
         "teddy = teddy/im2.ppm teddy/im6.ppm (Middlebury 2003)"},
        {{"Aloe/view1.png", "Aloe/view5.png", "Aloe/disp1.png"},
         "Aloe = Aloe/view1.png Aloe/view5.png (Middlebury 2006)"},
        {{"trainingQ/Piano/im0.png", "trainingQ/Piano/im1.png", "trainingQ/Piano/calib.txt",
          "trainingQ/Piano/disp0.pfm", "trainingQ/Piano/mask0nocc.png"},
         "trainingQ/Piano = trainingQ/Piano/im0.png trainingQ/Piano/im1.png trainingQ/Piano/calib.txt "
         "(Middlebury 2014)"},
        {{"image_2/000000_10.png", "image_3/000000_10.png", "calib_cam_to_cam/000000.txt"},
         "000000_10 = image_2/000000_10.png image_3/000000_10.png calib_cam_to_cam/000000.txt (KITTI)"},
        {{"colored_0/000000_10.png", "colored_1/000000_10.png", "calib/000000.txt"},
         "000000_10 = colored_0/000000_10.png colored_1/000000_10.png calib/000000.txt (KITTI 2012)"},
        {{"00/image_0/000000.png", "00/image_1/000000.png", "00/calib.txt"},
         "00/000000 = 00/image_0/000000.png 00/image_1/000000.png 00/calib.txt (KITTI, grey)"},
        {{"d/s/image_02/data/01.png", "d/s/image_03/data/01.png", "d/calib_cam_to_cam.txt"},
         "d/s/01 = d/s/image_02/data/01.png d/s/image_03/data/01.png d/calib_cam_to_cam.txt (KITTI raw)"},
        {{"mav0/cam0/data/14.png", "mav0/cam1/data/14.png", "mav0/cam0/sensor.yaml", "mav0/cam0/data.csv"},
         "mav0/14 = mav0/cam0/data/14.png mav0/cam1/data/14.png mav0/cam0/sensor.yaml (EuRoC)"},
        {{"cam0/1.png", "cam1/1.png"}, "1 = cam0/1.png cam1/1.png (folders cam0 and cam1)"},
        {{"left/left01.png", "right/right01.png"},
         "01 = left/left01.png right/right01.png (left- and right- in folders)"},
        {{"left/01_left.png", "right/01_right.png"},
         "01 = left/01_left.png right/01_right.png (-left and -right in folders)"},
        {{"s/left/01.png", "s/right/01.png", "s/calib/01.txt"},
         "s/01 = s/left/01.png s/right/01.png s/calib/01.txt (folders left and right)"},
        {{"Tree-Left.JPG", "Tree-Right.JPG", "calib.txt"},
         "Tree = Tree-Left.JPG Tree-Right.JPG calib.txt (-left and -right)"},
        {{"left01.jpg", "right01.jpg", "calib01.yml"},
         "01 = left01.jpg right01.jpg calib01.yml (left- and right-)"},
        {{"a_L.png", "a_R.png", "a_calib.txt"}, "a = a_L.png a_R.png a_calib.txt (-L and -R)"},
        {{"l-07.png", "r-07.png"}, "07 = l-07.png r-07.png (L- and R-)"},
        {{"garden.JPS"}, "garden = garden.JPS (JPS)"},
        {{"garden.pns"}, "garden = garden.pns (PNS)"},
        {{"DSCF0001.MPO"}, "DSCF0001 = DSCF0001.MPO (MPO)"},
    };
    std::vector<std::string> rules;
    for (const Example& example : examples) {
        EXPECT_EQ(found_in(example.files), std::vector<std::string>{example.unit});
        rules.push_back(example.unit.substr(example.unit.rfind(" (") + 2));
        rules.back().pop_back();
    }
    for (const PairRule& rule : pair_rules())
        if (!*rule.marker) {
            EXPECT_NE(std::find(rules.begin(), rules.end(), rule.name), rules.end()) << rule.name;
        }
}

TEST(FolderRows, AHeicIsAUnitIfItHoldsBothViews) {
    const TemporaryFolder folder;
    write_text(folder / "spatial.heic", "ftypheic....meta....grpl....ster....");
    write_text(folder / "photo.HEIC", "ftypheic....meta....");
    EXPECT_EQ(found_in(folder), std::vector<std::string>{"spatial = spatial.heic (spatial photograph)"});
}

TEST(FolderRows, AFolderThatIsASceneIsNamedAsItIs) {
    const TemporaryFolder folder;
    make_files(folder, {"Piano/im0.png", "Piano/im1.png"});
    for (const std::string name : {"Piano", "Piano/"}) {
        const auto units = read_manifest(folder / name, kFolderOptions);
        ASSERT_EQ(units.size(), 1u);
        EXPECT_EQ(units[0].name, "Piano");
    }
}

TEST(FolderRows, AFileBelongsToOneUnit) {
    EXPECT_EQ(found_in({"left/a_left.png", "left/a_right.png", "right/a_left.png"}),
              (std::vector<std::string>{
                  "a_left = left/a_left.png right/a_left.png (folders left and right)",
                  "a_right! its right image is missing: right/a_right.* (folders left and right)"}));
    EXPECT_EQ(found_in({"left.png", "right.png", "im0.png", "im1.png"}).size(), 1u)
        << "one unit is named after the folder";
    EXPECT_EQ(found_in({"a_left.png", "a_left.jpg", "a_right.jpg"}),
              std::vector<std::string>{"a = a_left.png a_right.jpg (-left and -right)"});
}

TEST(FolderRows, ForeignFilesAreLeftAlone) {
    EXPECT_EQ(found_in({"a_left.png", "a_right.png", "._a_left.png", ".trash/b_left.png", "wall.png",
                        "hour.png", "leftovers.png", "photo_l.jpg", "bright.png", "im6.png", "thumbs.db",
                        "a_left.txt", "deep/1/2/3/c_left.png", "a_disp.pfm", "disp_left.png",
                        "disp_right.png", "other/disp_left.png", "x/im0.png"}),
              std::vector<std::string>{"a = a_left.png a_right.png (-left and -right)"});
    const TemporaryFolder folder;
    make_files(folder, {"wall.png", "notes.txt"});
    const std::string message = test::error_of([&] { read_manifest(folder.path(), kFolderOptions); });
    for (const PairRule& rule : pair_rules()) EXPECT_CONTAINS(message, rule.files());
}

TEST(FolderRows, AViewWithoutTheOtherIsTold) {
    EXPECT_EQ(found_in({"x/im0.png", "y/im0.png", "y/im1.png", "right/2.png", "left/1.png", "left/2.png",
                        "a_left.png", "a_right.png", "c_right.png", "1/d_left.png"}),
              (std::vector<std::string>{"2 = left/2.png right/2.png (folders left and right)",
                                        "a = a_left.png a_right.png (-left and -right)",
                                        "y = y/im0.png y/im1.png (Middlebury 2014)",
                                        "1! its right image is missing: right/1.* (folders left and right)",
                                        "c! its left image is missing: c_left.* (-left and -right)",
                                        "x! its right image is missing: x/im1.* (Middlebury 2014)"}));
}

TEST(FolderRows, TheOrderIsThatOfFoldersRulesAndNames) {
    EXPECT_EQ(found_in({"b/2_L.png", "b/2_R.png", "b/10_L.png", "b/10_R.png", "a/im0.png", "a/im1.png",
                        "z.mpo", "y_left.png", "y_right.png"}),
              (std::vector<std::string>{"y = y_left.png y_right.png (-left and -right)", "z = z.mpo (MPO)",
                                        "a = a/im0.png a/im1.png (Middlebury 2014)",
                                        "b/10 = b/10_L.png b/10_R.png (-L and -R)",
                                        "b/2 = b/2_L.png b/2_R.png (-L and -R)"}));
}

TEST(FolderRows, PatternsTakeTheRulesWords) {
    const TemporaryFolder folder;
    make_files(folder, {"a/im0.png", "a/im1.png", "a/calib.txt", "image_2/1.png", "image_3/1.png",
                        "left/sceneleft.png", "right/sceneright.png"});
    const auto words = [&](const std::string& pattern) {
        const auto units = read_manifest(folder / pattern, kFolderOptions);
        return units.size() == 1 && units[0].wrong.empty()
                   ? Words(units[0].words.begin(), units[0].words.end() - 4)
                   : Words{};
    };
    EXPECT_EQ(words("{name}/im0.png"), (Words{"--left", folder / "a/im0.png", "--right", folder / "a/im1.png",
                                              "--calib", folder / "a/calib.txt"}));
    EXPECT_EQ(words("image_2/{name}.*"),
              (Words{"--left", folder / "image_2/1.png", "--right", folder / "image_3/1.png"}));
    EXPECT_EQ(words("left/{name}left.png"),
              (Words{"--left", folder / "left/sceneleft.png", "--right", folder / "right/sceneright.png"}));
}

TEST(FolderRows, ThePageListsAllRules) {
    std::string rows;
    for (const PairRule& rule : pair_rules()) {
        const auto quoted = [](const std::string& text) { return "`" + text + "`"; };
        std::string calibrations;
        for (const std::string file : rule.calibrations)
            calibrations += (calibrations.empty() ? "" : ", ") + quoted(file);
        rows += "| " + std::string(rule.name) + " | " + quoted(rule.left) +
                (*rule.right ? " and " + quoted(rule.right) : "") + " | " + calibrations + " |\n";
    }
    std::ifstream file(HEXRELIEF_SOURCE_DIR "/pipeline/batch/FOLDERS.md");
    std::stringstream page;
    page << file.rdbuf();
    EXPECT_CONTAINS(page.str(), "| --- | --- | --- |\n" + rows + "\n") << "write FOLDERS.md anew as this:\n"
                                                                       << rows;
}

}  // namespace
}  // namespace hexrelief::batch
