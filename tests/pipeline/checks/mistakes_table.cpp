// Makes each deliberate mistake on every pair and map of a folder with Middlebury's sets. Prints how many are
// noticed, and the figures behind the checks for correct and wrong inputs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "findings_table.h"
#include "middlebury_scenes.h"
#include "mistakes.h"
#include "pipeline/checks/checks.h"
#include "pipeline/checks/edge_fit.h"
#include "pipeline/checks/map_statistics.h"
#include "pipeline/checks/pair_statistics.h"
#include "pipeline/checks/thresholds.h"
#include "pipeline/data/error.h"
#include "tests/pipeline/checks/patterns.h"

namespace hexrelief::checks::mistakes {
namespace {

constexpr int kThreads = 1;

Findings judge(const StereoPair& pair, const matching::DisparityRange& range = {},
               stages::RangeOrigin origin = stages::RangeOrigin::chosen) {
    return check_pair(pair, stages::match_coarsely(pair, range.min_px, kThreads), range, origin, 1, kThreads);
}

// Checks a map whose samples were read with the scene's own scale.
Findings judge_map(const TestScene& scene, const DisparityMap& map, const Image& left) {
    return check_map(map, left, MapKind::disparity, {scene.files->scale});
}

int rounded_up(double count) {
    return 16 * static_cast<int>(std::ceil(count / 16));
}

void pair_figures(const StereoPair& pair, bool right, Table& table) {
    const stages::SmallMatch coarse = stages::match_coarsely(pair, 0, kThreads);
    table.figure("pair: agreed share", right, agreed_share(coarse), true, checks::kLeastAgreement);
    if (!right) return;
    table.figure("pair: textured share", right, textured_share(coarse.small.pair.left, kThreads), true,
                 checks::kLeastTexture);
    table.figure("pair: share at 0", right, share_at_zero(coarse), false, checks::kLeastAtZero);
    table.figure("pair: difference over slope", right, difference_over_slope(pair), true,
                 checks::kMostDifference);
    const RowFit rows = measure_rows(pair, coarse, kThreads);
    table.figure("pair: rows differ, px", right, rows.largest_px, false, checks::kLargestRow_px);
    table.figure("pair: agreeing points", right, rows.agreeing_share, true, checks::kLeastAgreeingPoints);
    const CoarsePoints points = match_coarse_points(coarse, kThreads);
    table.figure("pair: points below the range", right,
                 measure_low_end(points.matches, coarse.small.scale, 0).below_share, false,
                 checks::kMostBelow);
}

struct Exposure {
    const char* name;
    double gamma, gain;
};
constexpr Exposure kExposures[] = {
    {"gamma 0.7", 0.7, 1}, {"gamma 1.4", 1.4, 1}, {"gain 0.7", 1, 0.7}, {"gain 1.3", 1, 1.3}};

void right_pairs(const TestScene& scene, Table& table) {
    const auto& [left, right] = scene.pair;
    table.add("right pair", scene.name, judge(scene.pair), {});
    pair_figures(scene.pair, true, table);
    for (const Exposure& e : kExposures) {
        const Image other = exposed(right, e.gamma, e.gain);
        table.add("right pair, right view at " + std::string(e.name), scene.name, judge({left, other}), {});
        pair_figures({left, other}, true, table);
        table.add("right pair, both views at " + std::string(e.name), scene.name,
                  judge({exposed(left, e.gamma, e.gain), other}), {});
    }
}

void wrong_rows(const TestScene& scene, Table& table) {
    const Image &left = scene.pair.left, &right = scene.pair.right;
    const auto add = [&](const std::string& name, const Image& other, bool is_least) {
        const StereoPair pair{left, other};
        table.add(name, scene.name, judge(pair), {Mistake::rows_differ});
        if (!is_least) return;
        const stages::SmallMatch coarse = stages::match_coarsely(pair, 0, kThreads);
        if (agreed_share(coarse) < checks::kSureAgreement) return;
        table.figure("pair: rows differ, px", false, measure_rows(pair, coarse, kThreads).largest_px, false,
                     checks::kLargestRow_px);
    };
    for (const int rows : {2, -2, 8, 20})
        add("right view " + std::to_string(std::abs(rows)) + " rows " + (rows > 0 ? "lower" : "higher"),
            shifted(right, 0, rows), std::abs(rows) == 2);
    for (const double degrees : {0.5, -0.5, 2.0})
        add("right view turned by " + std::to_string(degrees).substr(0, 4) + " degrees",
            rotated(right, degrees), std::fabs(degrees) == 0.5);
}

void one_picture_twice(const Image& image, const std::string& scene, Table& table) {
    const auto add = [&](const std::string& name, const Image& other) {
        table.add("one picture twice" + name, scene, judge({image, other}), {Mistake::views_equal});
        table.figure("pair: difference over slope", false, difference_over_slope({image, other}), true,
                     checks::kMostDifference);
        table.figure("pair: share at 0", false,
                     share_at_zero(stages::match_coarsely({image, other}, 0, kThreads)), false,
                     checks::kLeastAtZero);
    };
    add("", image);
    for (const int quality : {90, 75, 50, 30})
        add(", once as JPEG of quality " + std::to_string(quality), as_stored(image, quality));
}

void wrong_pairs(const TestScene& scene, Table& table) {
    const auto& [left, right] = scene.pair;
    one_picture_twice(left, scene.name, table);
    table.add("views swapped", scene.name, judge({right, left}), {Mistake::views_swapped});
    {
        const stages::SmallMatch coarse = stages::match_coarsely({right, left}, 0, kThreads);
        const CoarsePoints points = match_coarse_points(coarse, kThreads);
        const LowEnd low = measure_low_end(points.matches, coarse.small.scale, 0);
        table.figure("swapped: points below 0", false, low.negative_share, false, checks::kSwappedBelow);
        table.figure("swapped: agreed the other way round", false, swapped_share(coarse, 1, kThreads), false,
                     checks::kSwappedAgreement);
    }
    wrong_rows(scene, table);
    const Image grey = plain(left, 120, 2, 1), black = plain(left, 3, 3, 1);
    table.add("grey pictures with noise", scene.name, judge({grey, plain(right, 120, 2, 2)}),
              {Mistake::no_texture});
    table.add("black pictures with noise", scene.name, judge({black, plain(right, 3, 3, 2)}),
              {Mistake::no_texture});
    table.add("right picture grey with noise", scene.name, judge({left, grey}), {Mistake::no_texture});
    table.figure("pair: textured share", false,
                 textured_share(stages::match_coarsely({grey, grey}, 0, 1).small.pair.left, 1), true,
                 checks::kLeastTexture);
    table.add("right picture mirrored", scene.name, judge({left, mirrored(right)}),
              {Mistake::views_unrelated});
}

void unrelated_pairs(const std::vector<TestScene>& scenes, Table& table) {
    for (const TestScene& a : scenes)
        for (const TestScene& b : scenes) {
            if (&a == &b || a.pair.left.empty() || b.pair.left.empty()) continue;
            const int width = std::min(a.pair.left.width, b.pair.left.width);
            const int height = std::min(a.pair.left.height, b.pair.left.height);
            const StereoPair pair{cropped(a.pair.left, width, height), cropped(b.pair.right, width, height)};
            table.add("pictures of two scenes", a.name + " and " + b.name, judge(pair),
                      {Mistake::views_unrelated});
            pair_figures(pair, false, table);
            const CoarsePoints points =
                match_coarse_points(stages::match_coarsely(pair, 0, kThreads), kThreads);
            if (points.rows.points >= checks::kLeastPoints)
                table.figure("pair: agreeing points", false, points.rows.agreeing_share, true,
                             checks::kLeastAgreeingPoints);
        }
}

void ranges(const TestScene& scene, Table& table) {
    const int right = rounded_up(scene.largest_px + 1);
    const auto judge_range = [&](int min_px, int count) {
        return judge(scene.pair, {min_px, count}, stages::RangeOrigin::given);
    };
    table.add("right range given", scene.name, judge_range(0, right), {});
    table.add("right range and a half given", scene.name, judge_range(0, rounded_up(1.5 * right)), {});
    const stages::SmallMatch coarse = stages::match_coarsely(scene.pair, 0, kThreads);
    table.figure("range: at its low end", true, share_at_low_end(coarse), false, checks::kMostAtLowEnd);
    const HighEnd high = measure_high_end(coarse, right);
    table.figure("range: beyond", true, high.beyond_share, false, checks::kMostBeyond);
    table.figure("range: times the scene's", true, rounded_up(1.5 * right) / (high.largest_px + 1), false,
                 checks::kWidestRange);
    const int half = rounded_up(0.5 * right);
    if (half < scene.largest_px) {
        table.add("range halved", scene.name, judge_range(0, half), {Mistake::range_ends_low});
        table.figure("range: beyond", false, measure_high_end(coarse, half).beyond_share, false,
                     checks::kMostBeyond);
    }
    if (4 * right <= scene.pair.left.width) {
        table.add("range of 4 times", scene.name, judge_range(0, 4 * right), {Mistake::range_wide});
        table.figure("range: times the scene's", false, 4 * right / (high.largest_px + 1), false,
                     checks::kWidestRange);
    }
    const int back = static_cast<int>(0.6 * scene.largest_px);
    const StereoPair converged{scene.pair.left, shifted(scene.pair.right, back, 0)};
    const stages::SmallMatch low = stages::match_coarsely(converged, 0, kThreads);
    table.figure("pair: points below the range", false,
                 measure_low_end(match_coarse_points(low, kThreads).matches, low.small.scale, 0).below_share,
                 false, checks::kMostBelow);
    table.figure("range: at its low end", false, share_at_low_end(low), false, checks::kMostAtLowEnd);
    table.add("disparities on both sides of 0", scene.name, judge(converged),
              {Mistake::range_begins_high, Mistake::views_swapped});
}

void cameras(const TestScene& scene, Table& table) {
    const SceneFiles& f = *scene.files;
    if (f.focal_px == 0 || scene.pair.left.empty()) return;
    const double median_px = median_disparity_px(stages::match_coarsely(scene.pair, 0, kThreads));
    const auto camera = [&](double factor) {
        return Calibration{.focal_px = f.focal_px,
                           .baseline_m = f.baseline_m * factor,
                           .doffs_px = f.doffs_px,
                           .metric = true};
    };
    table.add("right camera", scene.name, check_camera(camera(1), median_px), {});
    table.add("baseline in mm", scene.name, check_camera(camera(1000), median_px), {Mistake::baseline_in_mm});
    table.add("baseline in km", scene.name, check_camera(camera(0.001), median_px),
              {Mistake::depth_implausible});
}

void map_figures(const DisparityMap& map, const Image& left, bool right, const std::string& what,
                 Table& table) {
    const MapValues values = measure_values(map);
    const double straightness = measure_straightness(map);
    if (right || what == "depth")
        table.figure("map: row correlation and straightness", right,
                     values.row_correlation + checks::kStraightnessWeight * straightness, true,
                     checks::kDepthLike);
    if (right || what == "large")
        table.figure("map: largest of the width", right, values.largest_px / map.width, false,
                     checks::kLargest);
    if ((right && values.are_bytes) || what == "bytes")
        table.figure("map: largest of the width, bytes", right, values.largest_px / map.width, false,
                     checks::kLargestOfBytes);
    if (right || what == "small")
        table.figure("map: largest of the width, at least", right, values.largest_px / map.width, true,
                     checks::kLeastOfLargest);
    const TurningPoints turns = measure_turning(map);
    if (turns.count >= checks::kLeastTurns && (right || what == "colors")) {
        table.figure("map: turns at the largest value", right, turns.topmost_share, false,
                     checks::kMostTopmost);
        if (turns.topmost_share > checks::kMostTopmost)
            table.figure("map: roundness of such turns", right, turns.roundness, true,
                         checks::kLeastRoundness);
    }
    if (left.empty() || !(right || what == "unrelated")) return;
    const EdgeFit fit = measure_edge_fit(map, left);
    if (const auto both = fit_of(fit)) table.figure("colour: fit", right, *both, true, checks::kLeastFit);
    for (const AxisFit& axis : {fit.columns, fit.rows})
        if (right && axis.steps >= checks::kLeastSteps && std::abs(axis.best_px) >= checks::kLeastShift_px)
            table.figure("colour: fit gained elsewhere", right, axis.best - axis.here, false,
                         checks::kShiftedGain);
}

// Adds sparse maps, and disparities made from depth maps, either metric or relative (up to scale and offset).
void right_maps(const TestScene& scene, Table& table) {
    const Image& left = scene.pair.left;
    table.add("right map", scene.name, judge_map(scene, scene.map, left), {});
    map_figures(scene.map, left, true, "", table);
    for (const std::string& pattern : checks::patterns()) {
        const DisparityMap thin = checks::thinned(scene.map, pattern);
        table.add("right map, " + pattern, scene.name, judge_map(scene, thin, left), {});
        table.add(
            "depth in m, " + pattern, scene.name,
            check_map(with_values(thin, [&](double d) { return 100 / (d + scene.files->doffs_px); }), left),
            {Mistake::values_are_depth});
    }
    const double doffs_px = scene.files->doffs_px, largest_px = scene.largest_px;
    const auto of_depths = [&](const std::function<double(double)>& value_of) {
        return check_map(with_values(scene.map, value_of), left, MapKind::depth);
    };
    table.add("right depths", scene.name, of_depths([&](double d) { return d + doffs_px; }), {});
    table.add("right inverse depths from 0 to 1", scene.name,
              of_depths([&](double d) { return d / largest_px; }), {});
}

void map_values(const TestScene& scene, Table& table) {
    const SceneFiles& f = *scene.files;
    const auto add = [&](const std::string& name, const std::function<double(double)>& value_of,
                         const std::vector<Mistake>& expected, const std::string& what) {
        const DisparityMap map = with_values(scene.map, value_of);
        table.add(name, scene.name, judge_map(scene, map, scene.pair.left), expected);
        map_figures(map, {}, false, what, table);
    };
    const double focal_px = f.focal_px > 0 ? f.focal_px : 3740 / f.scale, baseline_m = 0.16;
    const std::vector<Mistake> depth{Mistake::values_are_depth}, large{Mistake::values_large},
        small{Mistake::values_small};
    const auto depth_m = [=](double d) { return focal_px * baseline_m / (d + f.doffs_px); };
    add("depth in m, float", depth_m, depth, "depth");
    add(
        "depth in mm, float", [&](double d) { return 1000 * depth_m(d); }, depth, "depth");
    add(
        "depth in mm, 16 bits as KITTI's", [&](double d) { return std::round(1000 * depth_m(d)) / 256; },
        depth, "depth");
    add(
        "depth without dmin, in mm, 16 bits as KITTI's",
        [&](double d) { return std::round(1000 * focal_px * baseline_m / d) / 256; }, depth, "depth");
    add(
        "256 times too large", [](double d) { return 256 * d; }, large, "large");
    add(
        "256 times too small", [](double d) { return d / 256; }, small, "small");
    if (f.scale > 1)
        add(
            "8 bits with scale 1", [&](double d) { return d * f.scale; }, large, "bytes");
    add(
        "8 bits with scale 256", [&](double d) { return d * f.scale / 256; }, small, "small");
    const double jet_scale = std::max(1.0, f.scale);
    add(
        "grey of jet",
        [&](double d) { return std::round(grey_of_jet(std::round(255 * d / scene.largest_px))) / jet_scale; },
        {Mistake::values_are_colors, Mistake::values_large}, "colors");
}

// Adds right maps as matchers and networks leave them, and right pictures that show little of the scene's
// edges.
void right_colors(const TestScene& scene, Table& table) {
    const Image& left = scene.pair.left;
    const auto add = [&](const std::string& name, const DisparityMap& map, const Image& image) {
        table.add("right map, " + name, scene.name, check_map(map, image), {});
        map_figures(map, image, true, "", table);
    };
    for (const Exposure& e : kExposures)
        add("colour at " + std::string(e.name), scene.map, exposed(left, e.gamma, e.gain));
    add("colour at gain 0.15", scene.map, exposed(left, 1, 0.15));
    add("colour grey", scene.map, as_grey(left));
    for (const int amplitude : {15, 30})
        for (const int block : {1, 3})
            add("texture " + std::to_string(amplitude) + " of " + std::to_string(block) + " px", scene.map,
                textured(left, amplitude, block));
    const DisparityMap dense = filled(scene.map);
    for (const int px : {2, 4, 6}) add("enlarged by " + std::to_string(px), enlarged(dense, px), left);
    for (const int px : {2, 4, 8}) add("blurred by " + std::to_string(px), blurred(dense, px), left);
    for (const int factor : {4, 8}) add("reduced by " + std::to_string(factor), coarse(dense, factor), left);
    const int width = left.width / 2, height = left.height / 2;
    for (const int y : {0, height})
        for (const int x : {0, width})
            add("a quarter of the picture", cropped(scene.map, x, y, width, height),
                cropped(left, width, height, x, y));
}

void wrong_colors(const TestScene& scene, const std::vector<TestScene>& scenes, const DisparityMap& map,
                  const std::string& of, Table& table) {
    const Image& left = scene.pair.left;
    const auto add = [&](const std::string& name, const Image& image, const std::vector<Mistake>& expected,
                         const std::string& with = "") {
        table.add(of + name, scene.name + with, check_map(map, image), expected);
        map_figures(map, image, false,
                    expected.size() == 1 && expected[0] == Mistake::color_unrelated ? "unrelated" : "",
                    table);
    };
    const std::vector<Mistake> either{Mistake::color_elsewhere, Mistake::color_unrelated};
    add("colour 8 px right", shifted(left, 8, 0), either);
    add("colour 8 px left", shifted(left, -8, 0), either);
    add("colour 8 px higher", shifted(left, 0, -8), either);
    add("colour mirrored", mirrored(left), {Mistake::color_mirrored, Mistake::color_unrelated});
    add("colour upside down", rotated(mirrored(left), 180),
        {Mistake::rows_flipped, Mistake::color_unrelated});
    add("colour is the right view", scene.pair.right, either);
    for (const TestScene& other : scenes) {
        const Image& image = other.pair.left;
        if (&other == &scene || image.width < left.width || image.height < left.height) continue;
        if (other.name.substr(0, 4) == scene.name.substr(0, 4)) continue;
        add("colour of another scene", cropped(image, left.width, left.height),
            {Mistake::color_unrelated, Mistake::color_elsewhere}, " with " + other.name);
    }
}

void map_colors(const TestScene& scene, const std::vector<TestScene>& scenes, Table& table) {
    if (scene.pair.left.empty()) return;
    right_colors(scene, table);
    wrong_colors(scene, scenes, scene.map, "", table);
    wrong_colors(scene, scenes, blurred(filled(scene.map), 2), "blurred, ", table);
}

void measure(const std::filesystem::path& data, const std::string& wanted, bool maps_alone) {
    const std::vector<TestScene> scenes = load(data, wanted);
    Table table;
    for (const TestScene& scene : scenes) {
        right_maps(scene, table);
        map_values(scene, table);
        map_colors(scene, scenes, table);
        if (scene.pair.left.empty() || maps_alone) continue;
        right_pairs(scene, table);
        wrong_pairs(scene, table);
        ranges(scene, table);
        cameras(scene, table);
    }
    if (!maps_alone) unrelated_pairs(scenes, table);
    table.print();
}

}  // namespace
}  // namespace hexrelief::checks::mistakes

int main(int count, char** arguments) {
    if (count < 2 || count > 4) {
        std::fprintf(
            stderr,
            "check_mistakes DIR [NAME [maps]]: the folder with middlebury2001/ and so on, and a part of "
            "the scenes' names; maps: no pairs\n");
        return 2;
    }
    try {
        hexrelief::checks::mistakes::measure(arguments[1], count > 2 ? arguments[2] : "", count > 3);
    } catch (const hexrelief::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return static_cast<int>(error.kind());
    }
}
