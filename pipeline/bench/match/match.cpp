#include "pipeline/bench/match/match.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>

#include "pipeline/bench/maps.h"
#include "pipeline/bench/match/match_rows.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/output_set.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/stages/sgbm.h"
#include "pipeline/stages/view_check.h"

namespace hexrelief {
namespace {

using namespace match;
using Json = nlohmann::ordered_json;

struct Method {
    std::string name, backend;
    std::function<void(DisparityConfig&)> configure;
    std::function<DisparityMap(const StereoPair&, const DisparityConfig&, int)> match;
};

DisparityMap match_on_cpu(const StereoPair& pair, const DisparityConfig& config, int threads) {
    return compute_disparity(pair, config, threads);
}

// StereoSGBM's own answer: both views agree on it, nothing is filled or refined.
DisparityMap match_by_opencv(const StereoPair& pair, const DisparityConfig& config, int threads) {
    RawViews views = match_views_sgbm(pair, with_range(pair, config, threads), threads);
    check_left_right(views.left, views.right, 1);
    remove_speckles(views.left, config.speckle_window_px, config.speckle_range_px);
    DisparityMap map{views.left.width, views.left.height, {}, {}};
    for (const std::int16_t d : views.left.values) {
        map.values.push_back(d == kUnmatched ? kUnknownDisparity : static_cast<float>(d) / kRawScale);
        map.origins.push_back(d == kUnmatched ? PixelOrigin::unknown : PixelOrigin::matched);
    }
    return map;
}

std::vector<Method> all_methods() {
    const auto sgm = [](DisparityConfig& config) { config.method = DisparityMethod::sgm; };
    const auto sgbm = [](DisparityConfig& config) { config.method = DisparityMethod::sgbm; };
    return {
        {"sgm", "cpu", sgm, match_on_cpu},
        {"sgbm", "cpu", sgbm, match_on_cpu},
        {"opencv", "cpu", sgbm, match_by_opencv},
    };
}

std::vector<std::string> names_of(const auto& entries) {
    std::vector<std::string> names;
    for (const auto& entry : entries)
        if (std::find(names.begin(), names.end(), entry.name) == names.end()) names.push_back(entry.name);
    return names;
}

template <typename Entry>
std::vector<Entry> chosen(const std::vector<Entry>& entries, const std::vector<std::string>& names,
                          const char* option) {
    check_names(names, names_of(entries), option);
    std::vector<Entry> result;
    for (const Entry& entry : entries)
        if (wanted(names, entry.name)) result.push_back(entry);
    return result;
}

struct LoadedScene {
    StereoPair pair;
    DisparityMap truth, right_truth;
};

LoadedScene load(const ScenePair& scene, const Disturbance& disturbance) {
    DisparityFileConfig file;
    file.scale = scene.scale;
    LoadedScene loaded{
        {read_image(scene.left), read_image(scene.right)}, read_disparity_map(scene.truth, file), {}};
    if (!scene.right_truth.empty()) loaded.right_truth = read_disparity_map(scene.right_truth, file);
    disturb(loaded.pair, disturbance);
    return loaded;
}

double percent_filled(const DisparityMap& map) {
    if (map.origins.empty()) return 0;
    return 100.0 * double(std::count(map.origins.begin(), map.origins.end(), PixelOrigin::filled)) /
           double(map.origins.size());
}

Row measure(const ScenePair& scene, const LoadedScene& loaded, const Method& method, DisparityConfig config,
            const MatchOptions& options, int threads) {
    method.configure(config);
    Row row{
        scene.name, scene.size, method.name, method.backend, loaded.pair.left.width, loaded.pair.left.height};
    row.disparities = with_range(loaded.pair, config, threads).num_disparities_px;
    DisparityMap map;
    for (int run = 0; run < options.runs; ++run) {
        const double begun = now_seconds();
        map = method.match(loaded.pair, config, threads);
        row.disparity.runs.push_back(now_seconds() - begun);
    }
    EvaluationConfig how;
    how.discontinuity_px = scene.discontinuity_px;
    if (!scene.right_truth.empty()) how.right_truth = &loaded.right_truth;
    row.evaluation = evaluate_disparity(map, loaded.truth, how);
    row.filled_percent = percent_filled(map);
    return row;
}

}  // namespace

void run_bench_match(const MatchOptions& options, std::ostream& out) {
    if (options.runs < 1) throw Error(ErrorKind::usage, "--runs: must be at least 1");
    Config config;
    for (const std::string& setting : options.settings) apply_setting(config, setting);
    for (const std::string& warning : config.warnings)
        if (options.warns) options.warns(warning);
    check_disturbance(options.disturbance);
    const std::vector<Method> methods = chosen(all_methods(), options.methods, "--methods");
    std::vector<std::string> left_out;
    const std::vector<ScenePair> found = find_scenes(options.data, left_out);
    if (found.empty())
        throw Error(ErrorKind::input, "--data " + options.data.string() +
                                          ": no folder below it holds left.*, right.* and disp.*");
    const std::vector<ScenePair> scenes = chosen(found, options.scenes, "--scenes");
    if (!options.json.empty()) check_writable_file(options.json);
    const int threads = effective_threads(options.threads);

    Json json;
    json["schema"] = 1;
    json["version"] = HEXRELIEF_VERSION;
    json["threads"] = threads;
    json["settings"] = options.settings;
    json["noise_percent"] = options.disturbance.noise_percent;
    json["gamma"] = options.disturbance.gamma;
    json["gain"] = options.disturbance.gain;
    json["left_out"] = left_out;
    json["rows"] = Json::array();
    json["means"] = Json::array();
    if (const Disturbance& d = options.disturbance; d.noise_percent != 0 || d.gamma != 1 || d.gain != 1)
        out << format("Noise of %g %% on both images, gamma %g and gain %g on the right one.\n",
                      d.noise_percent, d.gamma, d.gain);
    for (const std::string& name : left_out) out << "left out: " << name << '\n';
    out << "CPU threads: " << threads << ". Seconds of the whole disparity stage, median of " << options.runs
        << ". edge: near true discontinuities, on the wrong side or unknown.\n"
        << headings() << std::flush;
    std::vector<Row> rows;
    for (const ScenePair& scene : scenes) {
        const LoadedScene loaded = load(scene, options.disturbance);
        for (const Method& method : methods) {
            rows.push_back(measure(scene, loaded, method, config.disparity, options, threads));
            out << row_text(rows.back()) << std::flush;
            json["rows"].push_back(row_json(rows.back()));
        }
    }
    out << '\n';
    for (const Average& average : averages(rows)) {
        out << average_text(average);
        json["means"].push_back(average_json(average));
    }
    write_json(options.json, json.dump(2) + "\n");
}

}  // namespace hexrelief
