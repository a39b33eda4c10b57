#include "pipeline/job/matchers/network/network_matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>

#include "pipeline/data/error.h"
#include "pipeline/job/matchers/network/network.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

// The graphs of make_models.py.
class NetworkMatcherTest : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        if (std::system("/usr/bin/python3 -c 'import onnx' 2>/dev/null") != 0) return;
        folder_ = std::make_unique<test::TemporaryFolder>();
        const std::string script = std::string(HEXRELIEF_SOURCE_DIR) + "/tests/pipeline/job/make_models.py";
        ASSERT_EQ(std::system(("/usr/bin/python3 " + script + " " + folder_->path().string()).c_str()), 0);
    }
    static void TearDownTestSuite() { folder_.reset(); }
    void SetUp() override {
        if (!folder_) GTEST_SKIP() << "Debian's python3-onnx is not installed";
    }
    static fs::path model(const std::string& name) { return folder_->path() / (name + ".onnx"); }
    static NetworkAnswer match(const std::string& name, const StereoPair& pair, int ndisp = 16) {
        return NetworkMatcher(model(name), "", 1).match(pair, ndisp);
    }
    // Expects the levels of red, changed as the network's row says.
    static void expect_red(const NetworkAnswer& answer, const Image& left, double divisor = 1,
                           double mean = 0, double std = 1, double within = 1e-5) {
        ASSERT_EQ(answer.map.width, left.width);
        ASSERT_EQ(answer.map.height, left.height);
        for (int y = 0; y < left.height; ++y)
            for (int x = 0; x < left.width; ++x)
                ASSERT_NEAR(answer.map.at(x, y), (left.at(x, y)[0] / divisor - mean) / std, within)
                    << x << " " << y;
    }

    static std::unique_ptr<test::TemporaryFolder> folder_;
};
std::unique_ptr<test::TemporaryFolder> NetworkMatcherTest::folder_;

// Pictures of which each pixel has a colour of its own.
StereoPair pair_of(int width, int height) {
    StereoPair pair;
    for (Image* const image : {&pair.left, &pair.right}) {
        *image = {width, height, 3, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (const int level : {(7 * x + 13 * y) % 251, x % 256, y % 256})
                    image->pixels.push_back(static_cast<std::uint8_t>(level));
    }
    return pair;
}

std::string all_told(const NetworkAnswer& answer) {
    std::string text;
    for (const std::string& told : answer.told) text += told + "\n";
    return text;
}

TEST_F(NetworkMatcherTest, PicturesArePaddedToTheMultipleAndMapsCutOut) {
    const StereoPair pair = pair_of(75, 41);
    const NetworkAnswer answer = match("red", pair);
    expect_red(answer, pair.left);
    EXPECT_CONTAINS(all_told(answer), "padded to 96x64 px");
    EXPECT_TRUE(match("red", pair_of(96, 64)).told.empty());
}

TEST_F(NetworkMatcherTest, LevelsAreNormalisedAsTheTableSays) {
    const StereoPair pair = pair_of(40, 30);
    expect_red(match("imagenet-red", pair), pair.left, 255, 0.485, 0.229);
    expect_red(NetworkMatcher(model("red"), "unit", 1).match(pair, 16), pair.left, 255);
    EXPECT_CONTAINS(test::error_of([&] { NetworkMatcher(model("red"), "other", 1); }, ErrorKind::usage),
                    "disparity.model_kind must be one of levels, unit");
}

TEST_F(NetworkMatcherTest, GreyPicturesAreGivenInThreeChannels) {
    StereoPair pair = pair_of(40, 30);
    for (Image* const image : {&pair.left, &pair.right}) {
        image->channels = 1;
        image->pixels.resize(40 * 30);
    }
    expect_red(match("red", pair), pair.left);
}

TEST_F(NetworkMatcherTest, ANetworkOfAFixedSizeSeesTilesWithACollar) {
    const StereoPair pair = pair_of(300, 211);
    const NetworkAnswer answer = match("red-tiles", pair, 16);
    expect_red(answer, pair.left);
    EXPECT_CONTAINS(all_told(answer), "takes 128x96 px: the pair is matched in");
}

TEST_F(NetworkMatcherTest, DisparitiesThatNoTileHoldsMakeThePairSmaller) {
    // A picture of one colour has that level in any size; a disparity of the smaller pair is as much less.
    StereoPair pair = pair_of(300, 211);
    for (Image* const image : {&pair.left, &pair.right}) image->pixels.assign(image->pixels.size(), 8);
    const NetworkAnswer answer = match("red-tiles", pair, 64);
    ASSERT_EQ(answer.map.values.size(), std::size_t{300} * 211);
    for (const float d : answer.map.values) ASSERT_NEAR(d, 8 * 300 / 128.0, 1e-4);
    EXPECT_CONTAINS(all_told(answer), "made smaller, 128x90 px");
}

TEST_F(NetworkMatcherTest, WindowsKeepEachPixelOnce) {
    for (const int length : {10, 128, 129, 1000})
        for (const int before : {0, 32, 60}) {
            const std::vector<NetworkWindow> windows = windows_of(length, 128, before, 32);
            int kept = 0;
            for (const auto& [first, kept_first, kept_end] : windows) {
                EXPECT_EQ(kept_first, kept);
                EXPECT_TRUE(first == 0 || kept_first - first >= before) << length;
                EXPECT_TRUE(kept_end == length || first + 128 - kept_end >= 32) << length;
                EXPECT_LE(kept_end, first + 128);
                kept = kept_end;
            }
            EXPECT_EQ(kept, length);
        }
    EXPECT_TRUE(windows_of(129, 128, 70, 32).empty());
}

TEST_F(NetworkMatcherTest, OcclusionsAndConfidencesAreOneMap) {
    StereoPair pair = pair_of(32, 32);
    pair.left.pixels.assign(pair.left.pixels.size(), 2);
    const double sigmoid = 1 / (1 + std::exp(-2.0));
    const auto first = [](const NetworkAnswer& answer) {
        return answer.confidence.empty() ? -1 : answer.confidence[0];
    };
    EXPECT_NEAR(first(match("hidden-red", pair)), 1 - sigmoid, 1e-5);      // 1 means hidden
    EXPECT_NEAR(first(match("s2m2-red", pair)), sigmoid * sigmoid, 1e-5);  // 1 means visible
    EXPECT_EQ(first(match("red", pair)), -1);
}

TEST_F(NetworkMatcherTest, OtherFormsOfInputsAndOutputs) {
    StereoPair pair = pair_of(64, 32);
    expect_red(match("joined", pair), pair.left);
    pair.left.pixels.assign(pair.left.pixels.size(), 10);
    for (const float d : match("half", pair).map.values) ASSERT_NEAR(d, 20, 1e-4);  // in px of half the size
}

// OpenCV 4.6 lacks this operator, ONNX Runtime has it.
TEST_F(NetworkMatcherTest, AnOperatorIsRunOrNamed) {
    const StereoPair pair = pair_of(64, 64);
    if (network_library().starts_with("ONNX Runtime"))
        expect_red(match("grid-sample", pair), pair.left, 1, 0, 1, 1e-3);  // between places
    else
        EXPECT_CONTAINS(test::error_of([&] { match("grid-sample", pair); }),
                        "cannot run the network's operator 'GridSample'");
}

TEST_F(NetworkMatcherTest, WhatCannotBeRunIsRefusedInALine) {
    const StereoPair pair = pair_of(64, 64);
    const auto expect = [&](const std::string& name, const std::string& part) {
        EXPECT_CONTAINS(test::error_of([&] { match(name, pair); }), part);
        EXPECT_CONTAINS(test::error_of([&] { match(name, pair); }), name + ".onnx");
    };
    expect("own-operator", "cannot run the network's operator 'OwnOperator'");
    expect("four-inputs", "has 4 inputs");
    expect("many-channels", "has 5 channels");
    expect("volume", "no map of disparities, but 1x6x64x64");
    expect("huge", "takes pictures of 1048576x1048576 px");
    expect("cut-off", "no ONNX file, or it is cut off");
    expect("rubbish", "no ONNX file");
    expect("empty", "no ONNX file");
    expect("parts", "weights are in other files");
    expect("none", "none.onnx");
}

TEST_F(NetworkMatcherTest, WrittenShapesAreReadAgain) {
    const ModelFile model_file = read_model_file(model("block"));
    ASSERT_EQ(model_file.inputs.size(), 2u);
    EXPECT_EQ(model_file.inputs[0].name, "left");
    EXPECT_EQ(model_file.inputs[0].dims, (std::vector<long long>{1, 3, 0, 0}));
    EXPECT_EQ(model_file.outputs[1].name, "disparity");
    const std::vector<int> shape{1, 3, 100000, 7};
    const std::vector<std::uint8_t> fixed = with_shapes(model_file, {shape, shape});
    std::ofstream(model("again"), std::ios::binary)
        .write(reinterpret_cast<const char*>(fixed.data()), static_cast<std::streamsize>(fixed.size()));
    const ModelFile again = read_model_file(model("again"));
    ASSERT_EQ(again.inputs.size(), 2u);
    EXPECT_EQ(again.inputs[1].name, "right");
    EXPECT_EQ(again.inputs[1].dims, (std::vector<long long>{1, 3, 100000, 7}));
    EXPECT_EQ(again.outputs.size(), 2u);
}

TEST_F(NetworkMatcherTest, AnyBytesAreReadOrRefused) {
    std::ifstream in(model("block"), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    const fs::path path = model("damaged");
    unsigned random = 1;
    const auto next = [&](std::size_t below) {
        random = random * 1664525 + 1013904223;
        return static_cast<std::size_t>(random >> 8) % below;
    };
    for (int i = 0; i < 500; ++i) {
        std::string bytes = whole.substr(0, i % 2 == 0 ? whole.size() : next(whole.size()));
        for (int k = 0; k < 3 && !bytes.empty(); ++k)
            bytes[next(bytes.size())] = static_cast<char>(next(256));
        std::ofstream(path, std::ios::binary) << bytes;
        test::refusal_of([&] { EXPECT_FALSE(read_model_file(path).inputs.empty()); });
    }
}

TEST(NetworkMatcher, OperatorsAreFoundInWhatLibrariesSay) {
    EXPECT_EQ(operator_in("error: (-2) in 'handleNode' > Node [GridSample@ai.onnx]:(disparity) parse error"),
              "GridSample");
    for (const char* const said :
         {"Could not find an implementation for Erf(13) node with name ''",
          "In Node, (\"\", Erf, \"\", -1) : , Error No Op registered for Erf with domain_version of 16",
          "Fatal error: my.ops:Erf(-1) is not a registered function/op",
          "Node () Op (Erf) [ShapeInferenceError] The last dimension of the grid tensor",
          "Non-zero status code returned while running Erf node. Name:'' Status Message: sizes differ"})
        EXPECT_EQ(operator_in(said), "Erf") << said;
    EXPECT_EQ(operator_in("something else"), "");
    EXPECT_EQ(
        reason_in("OpenCV(4.6.0) a.cpp:1: error: (-2:Unspecified error) in function 'f' > Node [X@ai]: parse "
                  "error: OpenCV(4.6.0) b.cpp:2: error: (-5:Bad argument) no kernel in function 'g'"),
        "no kernel");
    EXPECT_EQ(reason_in("something else"), "something else");
}

TEST(ModelKinds, TheTableIsSound) {
    ASSERT_FALSE(model_kinds().empty());
    EXPECT_EQ(model_kinds().front().name, "levels");
    for (const ModelKind& kind : model_kinds()) {
        for (const char c : kind.name) EXPECT_TRUE(std::isalnum(static_cast<unsigned char>(c))) << kind.name;
        for (const std::string& sum : kind.sha256) EXPECT_EQ(sum.size(), 64u) << kind.name;
        for (const double std : kind.std) EXPECT_GT(std, 0) << kind.name;
        EXPECT_GT(kind.divisor, 0) << kind.name;
        EXPECT_GT(kind.multiple, 0) << kind.name;
        EXPECT_FALSE(kind.what.empty()) << kind.name;
    }
    // The longest name that fits counts.
    const test::TemporaryFolder folder;
    const auto kind = [&](const std::string& name) {
        std::ofstream(folder.path() / name) << name;
        return kind_of_model(folder.path() / name, "").name;
    };
    EXPECT_EQ(kind("C-Fast-FoundationStereo_480x736.onnx"), "cfastfoundationstereo");
    EXPECT_EQ(kind("foundation_stereo.onnx"), "foundationstereo");
    EXPECT_EQ(kind("LiteAnyStereo-M.onnx"), "liteanystereo");
    EXPECT_EQ(kind("mine.onnx"), "levels");
}

}  // namespace
}  // namespace hexrelief::job
