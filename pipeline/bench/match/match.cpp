#include "pipeline/bench/match/match.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>

#include "pipeline/bench/backends.h"
#include "pipeline/bench/maps.h"
#include "pipeline/bench/match/match_rows.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
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
    DisparityMethod which;
    std::function<DisparityMap(const StereoPair&, const DisparityConfig&, int threads)> match;
};

// StereoSGBM's own answer: both views agree on it, nothing is filled or refined.
DisparityMap match_by_opencv(const StereoPair& pair, const DisparityConfig& config, int threads) {
    RawViews views = match_views_sgbm(pair, find_range(pair, {}, config, threads).config, threads);
    check_left_right(views.left, views.right, 1);
    remove_speckles(views.left, config.speckle_window_px, config.speckle_range_px);
    DisparityMap map{views.left.width, views.left.height, {}, {}};
    for (const std::int16_t d : views.left.values) {
        map.values.push_back(d == kUnmatched ? kUnknownDisparity : static_cast<float>(d) / kRawScale);
        map.origins.push_back(d == kUnmatched ? PixelOrigin::unknown : PixelOrigin::matched);
    }
    return map;
}

std::vector<Method> all_methods(const std::vector<BackendPointer>& backends) {
    const auto on = [](const BackendPointer& backend) {
        return [backend](const StereoPair& pair, const DisparityConfig& config, int threads) {
            return compute_disparity(pair, config, *backend, threads);
        };
    };
    std::vector<Method> methods;
    for (const BackendPointer& backend : backends)
        methods.push_back({"sgm", backend->name(), DisparityMethod::sgm, on(backend)});
    methods.push_back({"sgbm", "cpu", DisparityMethod::sgbm, on(backends.front())});
    methods.push_back({"opencv", "cpu", DisparityMethod::sgbm, match_by_opencv});
    return methods;
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
    config.method = method.which;
    Row row{
        scene.name, scene.size, method.name, method.backend, loaded.pair.left.width, loaded.pair.left.height};
    row.disparities = find_range(loaded.pair, {}, config, threads).config.num_disparities_px;
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

// What stands above the rows, as text and JSON.
Json begin(const MatchOptions& options, const std::vector<BackendPointer>& backends, int threads,
           const std::vector<std::string>& left_out, std::ostream& out) {
    Json json;
    json["schema"] = 1;
    json["version"] = HEXRELIEF_VERSION;
    json["threads"] = threads;
    json["backends"] = Json::array();
    for (const BackendPointer& backend : backends) {
        out << backend->name() << ": " << backend->device()
            << (backend->name() == "cpu" ? ", threads " + std::to_string(threads) : std::string()) << '\n';
        json["backends"].push_back({{"name", backend->name()}, {"device", backend->device()}});
    }
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
    out << "Seconds of the whole disparity stage, median of " << options.runs
        << ". edge: near true discontinuities, on the wrong side or unknown.\n"
        << headings() << std::flush;
    return json;
}

}  // namespace

void run_bench_match(const MatchOptions& options, std::ostream& out) {
    if (options.runs < 1) throw Error(ErrorKind::usage, "--runs: must be at least 1");
    Config config;
    for (const std::string& setting : options.settings) apply_setting(config, setting);
    for (const std::string& warning : config.warnings)
        if (options.warns) options.warns(warning);
    check_disturbance(options.disturbance);
    const int threads = effective_threads(options.threads);
    const std::vector<BackendPointer> backends = usable_backends(threads);
    const std::vector<Method> methods = chosen(all_methods(backends), options.methods, "--methods");
    std::vector<std::string> left_out;
    const std::vector<ScenePair> found = find_scenes(options.data, left_out);
    if (found.empty())
        throw Error(ErrorKind::input, "--data " + options.data.string() +
                                          ": no folder below it holds left.*, right.* and disp.*");
    const std::vector<ScenePair> scenes = chosen(found, options.scenes, "--scenes");
    if (!options.json.empty()) check_writable_file(options.json);

    Json json = begin(options, backends, threads, left_out, out);
    std::vector<Row> rows;
    for (const ScenePair& scene : scenes) {
        const LoadedScene loaded = load(scene, options.disturbance);
        for (const Method& method : methods) {
            // The first call on a device pays for its context, which belongs to no scene.
            if (rows.size() < methods.size() && method.backend != "cpu")
                method.match(loaded.pair, config.disparity, threads);
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
    write_json(options.json, json);
}

}  // namespace hexrelief
