#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "mistakes.h"
#include "pipeline/checks/checks.h"
#include "pipeline/checks/pair_statistics.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"

namespace hexrelief::checks {
namespace {

using namespace mistakes;

struct SampleFiles {
    StereoPair pair;
    DisparityMap disparity;
};

const SampleFiles& scene() {
    static const std::string folder = HEXRELIEF_SOURCE_DIR "/samples/";
    static const SampleFiles files{
        {readers::read_image(folder + "left.png"), readers::read_image(folder + "right.png")},
        readers::read_disparity_map(folder + "disparity.pfm", {})};
    return files;
}

std::vector<Mistake> mistakes_in(const std::vector<Finding>& findings) {
    std::vector<Mistake> result;
    for (const Finding& finding : findings) result.push_back(finding.mistake);
    return result;
}

std::vector<Finding> judge(const StereoPair& pair, const matching::DisparityRange& range = {},
                           stages::RangeOrigin origin = stages::RangeOrigin::chosen) {
    return check_pair(pair, stages::match_coarsely(pair, range.min_px, 1), range, origin, 1, 1);
}

std::vector<Mistake> found(const StereoPair& pair, const matching::DisparityRange& range = {},
                           stages::RangeOrigin origin = stages::RangeOrigin::chosen) {
    return mistakes_in(judge(pair, range, origin));
}

using List = std::vector<Mistake>;

TEST(CheckPair, SaysNothingOfARightPair) {
    const auto& [left, right] = scene().pair;
    EXPECT_EQ(found(scene().pair), List{});
    EXPECT_EQ(found({left, mistakes::exposed(right, 1.4, 1)}), List{});
    EXPECT_EQ(found(scene().pair, {0, 48}, stages::RangeOrigin::given), List{});
}

TEST(OccludedEdges, TellALeftViewWhateverTheSignOfItsDisparities) {
    const auto& [left, right] = scene().pair;
    const auto is_left = [](const StereoPair& pair) {
        return is_surely_left(stages::match_coarsely(pair, -40, 1, stages::kFineColumns));
    };
    EXPECT_TRUE(is_left(scene().pair));
    EXPECT_FALSE(is_left({right, left}));
    EXPECT_TRUE(is_left({left, mistakes::shifted(right, 20, 0)})) << "all disparities are below 0";
    EXPECT_FALSE(is_left({mistakes::shifted(right, 20, 0), left}));
    EXPECT_FALSE(is_left({left, left})) << "nothing is hidden";
    const auto is_right = [](const StereoPair& pair) {
        return is_surely_right(stages::match_coarsely(pair, -40, 1, stages::kFineColumns));
    };
    EXPECT_TRUE(is_right({right, left}));
    EXPECT_FALSE(is_right(scene().pair));
    EXPECT_FALSE(is_right({left, left}));
}

TEST(OccludedEdges, TheShadowOfOneThingTellsNoOrder) {
    // Boards before a wall; a lamp at the right camera throws the shadow where only the left one sees the
    // wall.
    const auto is_right = [](int boards) {
        constexpr int width = 640, height = 480, step = 16;
        const auto noise = [](int x, int y, int mean) {
            const unsigned hash =
                (static_cast<unsigned>(x) * 73856093U ^ static_cast<unsigned>(y) * 19349663U) * 2654435761U;
            return static_cast<std::uint8_t>(mean + static_cast<int>(hash >> 28));
        };
        StereoPair pair{{width, height, 1, std::vector<std::uint8_t>(std::size_t{width} * height)}, {}};
        pair.right = pair.left;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) *pair.left.at(x, y) = *pair.right.at(x, y) = noise(x, y, 160);
        for (int i = 0; i < boards; ++i)
            for (int y = 20; y < height - 20; ++y) {
                const int left = 80 + 90 * i;
                for (int x = left; x < left + 40; ++x)
                    *pair.left.at(x, y) = *pair.right.at(x - step, y) = noise(x, y, 40);
                for (int x = left - step; x < left; ++x) *pair.left.at(x, y) = noise(x, y, 45);
            }
        return is_surely_right(stages::match_coarsely(pair, -40, 1, width));
    };
    EXPECT_FALSE(is_right(1));
    EXPECT_FALSE(is_right(3));
    EXPECT_TRUE(is_right(6)) << "the same of many things does";
}

TEST(CheckPair, NoticesSwappedViews) {
    const auto findings = judge({scene().pair.right, scene().pair.left}, {0, 16}, stages::RangeOrigin::given);
    ASSERT_EQ(mistakes_in(findings), List{Mistake::views_swapped}) << "and nothing of the range";
    EXPECT_NE(findings[0].text.find("exchange --left and --right"), std::string::npos) << findings[0].text;
}

TEST(CheckPair, NoticesOnePictureGivenTwice) {
    const Image &left = scene().pair.left, &right = scene().pair.right;
    EXPECT_EQ(found({left, left}), List{Mistake::views_equal});
    EXPECT_EQ(found({left, left}, {0, 192}, stages::RangeOrigin::ndisp), List{Mistake::views_equal})
        << "and nothing of the range";
    EXPECT_EQ(found({left, mistakes::as_stored(left, 60)}), List{Mistake::views_equal});
    EXPECT_EQ(found({right, mistakes::as_stored(right, 90)}, {-32, 64}, stages::RangeOrigin::given),
              List{Mistake::views_equal});
    EXPECT_EQ(found({left, mistakes::shifted(left, -1, 0)}), List{})
        << "a wall, a pixel nearer than infinity";
}

TEST(CheckPair, NoticesRowsThatDiffer) {
    const auto& [left, right] = scene().pair;
    const auto findings = judge({left, mistakes::shifted(right, 0, 2)});
    ASSERT_EQ(mistakes_in(findings), List{Mistake::rows_differ});
    EXPECT_NE(findings[0].text.find("2 px lower in the middle"), std::string::npos) << findings[0].text;
    EXPECT_EQ(found({left, mistakes::shifted(right, 0, -12)}), List{Mistake::rows_differ});
    EXPECT_EQ(found({left, mistakes::rotated(right, 1)}), List{Mistake::rows_differ});
}

TEST(CheckPair, NoticesPicturesThatDoNotMatch) {
    const auto& [left, right] = scene().pair;
    EXPECT_EQ(found({left, mistakes::mirrored(right)}), List{Mistake::views_unrelated});
    EXPECT_EQ(found({mistakes::plain(left, 90, 2, 1), mistakes::plain(right, 90, 2, 2)}),
              List{Mistake::no_texture});
    EXPECT_EQ(found({mistakes::plain(left, 90, 0, 1), right}), List{})
        << "the matcher refuses a blank picture";
}

TEST(CheckPair, NoticesARangeThatDoesNotFit) {
    const StereoPair& pair = scene().pair;
    EXPECT_EQ(found(pair, {0, 16}, stages::RangeOrigin::given), List{Mistake::range_ends_low});
    EXPECT_EQ(found(pair, {0, 192}, stages::RangeOrigin::ndisp), List{Mistake::range_wide});
    EXPECT_EQ(found(pair, {0, 192}, stages::RangeOrigin::chosen), List{}) << "the program's own choice";
    EXPECT_EQ(found({pair.left, mistakes::shifted(pair.right, 16, 0)}), List{Mistake::range_begins_high});
    EXPECT_EQ(found({pair.left, mistakes::shifted(pair.right, 16, 0)}, {-32, 64}, stages::RangeOrigin::given),
              List{});
}

std::vector<Mistake> found(const DisparityMap& map, const Image& left = {}) {
    return mistakes_in(check_map(map, left));
}
std::vector<Mistake> found(const DisparityMap& map, const MapScale& stored) {
    return mistakes_in(check_map(map, {}, MapKind::disparity, stored));
}

TEST(CheckMap, SaysNothingOfARightMap) {
    EXPECT_EQ(found(scene().disparity, scene().pair.left), List{});
    EXPECT_EQ(found(DisparityMap{4, 2, std::vector<float>(8, 2)}), List{}) << "too little to judge";
}

TEST(CheckMap, TakesARoundObjectForNoColorMap) {
    for (const double steps : {1.0, 4.0})
        EXPECT_EQ(found(mistakes::with_values(scene().disparity,
                                              [=](double d) { return std::round(steps * d) / steps; }),
                        MapScale{steps}),
                  List{})
            << steps;
}

TEST(CheckMap, NoticesDepths) {
    const DisparityMap depth_mm =
        mistakes::with_values(scene().disparity, [](double d) { return 50000 / d; });
    EXPECT_EQ(found(depth_mm), List{Mistake::values_are_depth});
    EXPECT_EQ(found(mistakes::with_values(depth_mm, [](double z) { return std::round(z) / 256; })),
              List{Mistake::values_are_depth});
    EXPECT_EQ(found(mistakes::with_values(depth_mm, [](double z) { return z / 1000; })),
              List{Mistake::values_are_depth});
}

TEST(CheckMap, NoticesDepthsThatAreNone) {
    const DisparityMap& map = scene().disparity;
    const auto found_in = [](const DisparityMap& of) {
        return mistakes_in(check_map(of, scene().pair.left, MapKind::depth));
    };
    EXPECT_EQ(found_in(mistakes::with_values(map, [](double d) { return 5 * d; })), List{}) << "any scale";
    EXPECT_EQ(found_in(mistakes::with_values(map, [](double d) { return 100 / d; })),
              List{Mistake::depths_are_inverse});
}

// Returns depths in whole mm with noise that grows with their square, as depth cameras have it, of a plane
// with boxes on it. The plane leans by slope_per_row of its inverse depth.
DisparityMap leaning_scene(double slope_per_row) {
    DisparityMap map{160, 120, {}};
    std::uint32_t state = 7;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            state = state * 1664525u + 1013904223u;
            const bool on_box = (x / 20 + y / 20) % 3 == 0;
            const double inverse_m = 0.8 + slope_per_row * (y - 60) + (on_box ? 0.1 : 0);
            const double noise_m = 0.004 * ((state >> 8) / double(1 << 24) - 0.5) / (inverse_m * inverse_m);
            map.values.push_back(static_cast<float>(std::round(1000 * (1 / inverse_m + noise_m)) / 1000));
        }
    return map;
}

TEST(CheckMap, PlanesTellWhatIsNearWhereverItLies) {
    const auto inverse = [](const DisparityMap& map) {
        return mistakes::with_values(map, [](double d) { return 10 / d; });
    };
    for (const double slope : {-0.01, 0.01}) {
        const DisparityMap depths = leaning_scene(slope), disparities = inverse(depths);
        EXPECT_EQ(mistakes_in(check_map(disparities, {}, MapKind::depth)), List{}) << slope;
        EXPECT_EQ(found(disparities), List{}) << slope;
        EXPECT_EQ(mistakes_in(check_map(depths, {}, MapKind::depth)), List{Mistake::depths_are_inverse})
            << slope;
        EXPECT_EQ(found(mistakes::with_values(depths, [](double z) { return 10 * z; })),
                  List{Mistake::values_are_depth})
            << slope;
    }
}

TEST(CheckMap, NoticesAWrongScale) {
    const auto scaled = [](double factor) {
        return found(mistakes::with_values(scene().disparity, [=](double d) { return factor * d; }));
    };
    EXPECT_EQ(scaled(256), List{Mistake::values_large});
    EXPECT_EQ(scaled(1 / 256.0), List{Mistake::values_small});
    EXPECT_EQ(found(mistakes::with_values(scene().disparity, [](double d) { return std::round(4 * d); })),
              List{Mistake::values_large})
        << "8 bits with scale 1";
}

TEST(CheckMap, NoticesTheGreyOfColorsButNoPartsOfAPixel) {
    DisparityMap slope{160, 120, {}};
    for (int y = 0; y < slope.height; ++y)
        for (int x = 0; x < slope.width; ++x) slope.values.push_back(static_cast<float>(20 + y + x / 4));
    const DisparityMap grey =
        mistakes::with_values(slope, [](double d) { return std::round(mistakes::grey_of_jet(1.4 * d)); });
    const auto found_in = [](const DisparityMap& map, double scale, const MapScale& stored) {
        return found(mistakes::with_values(map, [=](double v) { return v / scale + stored.offset_px; }),
                     stored);
    };
    EXPECT_EQ(found_in(slope, 8, {8}), List{});
    const List colors{Mistake::values_are_colors};
    EXPECT_EQ(found_in(grey, 1, {}), colors);
    EXPECT_EQ(found_in(grey, 7, {7}), colors);
    EXPECT_EQ(found_in(grey, 16, {16, 1.5}), colors);
    EXPECT_EQ(found_in(grey, 16, {}), List{}) << "a map of floats in steps of 1/16 px";
}

TEST(CheckMap, NoticesAPictureOfSomethingElse) {
    const Image& left = scene().pair.left;
    EXPECT_EQ(found(scene().disparity, mistakes::shifted(left, 12, 0)), List{Mistake::color_elsewhere});
    const Image noise = mistakes::plain(left, 128, 100, 1);
    EXPECT_EQ(found(scene().disparity, noise), List{Mistake::color_unrelated});
    EXPECT_EQ(found(scene().disparity, mistakes::mirrored(left)), List{Mistake::color_mirrored});
    EXPECT_EQ(found(scene().disparity, scene().pair.right).size(), 1u);
}

// Maps as matchers of blocks and networks make them, and pictures whose texture hides the edges of things.
TEST(CheckMap, SaysNothingOfMapsWithWideEdgesAndOfStrongTexture) {
    const Image& left = scene().pair.left;
    const DisparityMap dense = mistakes::filled(scene().disparity);
    for (const int px : {2, 4}) {
        EXPECT_EQ(found(mistakes::enlarged(dense, px), left), List{}) << px;
        EXPECT_EQ(found(mistakes::blurred(dense, px), left), List{}) << px;
        EXPECT_EQ(found(mistakes::coarse(dense, px), left), List{}) << px;
    }
    EXPECT_EQ(found(scene().disparity, mistakes::textured(left, 30, 1)), List{});
    EXPECT_EQ(found(scene().disparity, mistakes::exposed(left, 1, 0.15)), List{});
}

TEST(CheckMap, NoticesRowsInTheOtherOrder) {
    const DisparityMap& map = scene().disparity;
    DisparityMap flipped = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) flipped.at(x, y) = map.at(x, map.height - 1 - y);
    const List seen = found(flipped, scene().pair.left);
    EXPECT_NE(std::find(seen.begin(), seen.end(), Mistake::rows_flipped), seen.end());
}

TEST(CheckMap, IsSilentOfMapsThatKnowFewPixels) {
    for (const int apart : {5, 20}) {
        DisparityMap rows = scene().disparity, scattered = rows;
        for (int y = 0; y < rows.height; ++y)
            for (int x = 0; x < rows.width; ++x) {
                if (y % apart != 0) rows.at(x, y) = kUnknownDisparity;
                if ((7 * x + 11 * y) % apart != 0) scattered.at(x, y) = kUnknownDisparity;
            }
        EXPECT_EQ(found(rows, scene().pair.left), List{});
        EXPECT_EQ(found(scattered, scene().pair.left), List{});
    }
}

TEST(CheckCamera, NoticesUnits) {
    Calibration camera{.focal_px = 1000, .baseline_m = 0.16};
    EXPECT_TRUE(check_camera(camera, 0.01).empty()) << "not metric";
    camera.metric = true;
    EXPECT_TRUE(check_camera(camera, 80).empty());
    EXPECT_TRUE(check_camera(camera, NAN).empty()) << "nothing is known of the scene";
    EXPECT_TRUE(check_camera(camera, 0).empty()) << "sky";
    EXPECT_EQ(mistakes_in(check_camera(camera, 0.1)), List{Mistake::depth_implausible});
    camera.baseline_m = 160;
    EXPECT_EQ(mistakes_in(check_camera(camera, 80)), List{Mistake::baseline_in_mm});
    EXPECT_NE(check_camera(camera, 80)[0].text.find("1.6 or 0.16"), std::string::npos);
    EXPECT_EQ(mistakes_in(check_depths(camera, 80)), List{Mistake::depth_implausible}) << "2 km";
    EXPECT_TRUE(check_depths(camera, 8000).empty()) << "whatever the baseline";
    camera.baseline_m = 0.00016;
    EXPECT_EQ(mistakes_in(check_camera(camera, 80)), List{Mistake::depth_implausible});
}

TEST(CheckFocal, NoticesMillimetres) {
    Calibration camera{.focal_px = 640, .width = 480, .height = 640};
    EXPECT_TRUE(check_focal(camera).empty());
    camera.focal_px = 160;
    EXPECT_TRUE(check_focal(camera).empty()) << "127 degrees, as the widest lenses have";
    camera.focal_px = 35;
    EXPECT_EQ(mistakes_in(check_focal(camera)), List{Mistake::focal_in_mm});
    EXPECT_NE(check_focal(camera)[0].text.find("168 degrees"), std::string::npos)
        << check_focal(camera)[0].text;
}

}  // namespace
}  // namespace hexrelief::checks
