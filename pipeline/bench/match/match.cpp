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

namespace hexrelief::bench {
namespace {

using namespace match;
using Json = nlohmann::ordered_json;

struct Method {
    std::string name, backend;
    stages::DisparityMethod which;
    std::function<DisparityMap(const StereoPair&, const stages::DisparityConfig&, int threads)> match;
};

// Returns StereoSGBM's disparities on which both views agree, neither filled nor refined.
DisparityMap match_by_opencv(const StereoPair& pair, const stages::DisparityConfig& config, int threads) {
    stages::RawViews views =
        stages::match_views_sgbm(pair, stages::find_range(pair, {}, config, threads).config, threads);
    stages::check_left_right(views.left, views.right, 1);
    stages::remove_speckles(views.left, config.speckle_window_px, config.speckle_range_px);
    DisparityMap map{views.left.width, views.left.height, {}, {}};
    for (const std::int16_t d : views.left.values) {
        map.values.push_back(d == stages::kUnmatched ? kUnknownDisparity
                                                     : static_cast<float>(d) / stages::kRawScale);
        map.origins.push_back(d == stages::kUnmatched ? PixelOrigin::unknown : PixelOrigin::matched);
    }
    return map;
}

std::vector<Method> all_methods(const std::vector<job::BackendPointer>& backends) {
    const auto on = [](const job::BackendPointer& backend) {
        return [backend](const StereoPair& pair, const stages::DisparityConfig& config, int threads) {
            return stages::compute_disparity(pair, config, *backend, threads);
        };
    };
    std::vector<Method> methods;
    for (const job::BackendPointer& backend : backends)
        methods.push_back({"sgm", backend->name(), stages::DisparityMethod::sgm, on(backend)});
    methods.push_back({"sgbm", "cpu", stages::DisparityMethod::sgbm, on(backends.front())});
    methods.push_back({"opencv", "cpu", stages::DisparityMethod::sgbm, match_by_opencv});
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

LoadedScene load(const match::ScenePair& scene, const match::Disturbance& disturbance) {
    readers::DisparityFileConfig file;
    file.scale = scene.scale;
    LoadedScene loaded{{readers::read_image(scene.left), readers::read_image(scene.right)},
                       readers::read_disparity_map(scene.truth, file),
                       {}};
    if (!scene.right_truth.empty()) loaded.right_truth = readers::read_disparity_map(scene.right_truth, file);
    match::disturb(loaded.pair, disturbance);
    return loaded;
}

double percent_filled(const DisparityMap& map) {
    if (map.origins.empty()) return 0;
    return 100.0 * double(std::count(map.origins.begin(), map.origins.end(), PixelOrigin::filled)) /
           double(map.origins.size());
}

match::Row measure(const match::ScenePair& scene, const LoadedScene& loaded, const Method& method,
                   stages::DisparityConfig config, const MatchOptions& options, int threads) {
    config.method = method.which;
    match::Row row{
        scene.name, scene.size, method.name, method.backend, loaded.pair.left.width, loaded.pair.left.height};
    row.disparities = stages::find_range(loaded.pair, {}, config, threads).config.num_disparities_px;
    DisparityMap map;
    for (int run = 0; run < options.runs; ++run) {
        const double begun = now_seconds();
        map = method.match(loaded.pair, config, threads);
        row.disparity.runs.push_back(now_seconds() - begun);
    }
    evaluation::EvaluationConfig how;
    how.discontinuity_px = scene.discontinuity_px;
    if (!scene.right_truth.empty()) how.right_truth = &loaded.right_truth;
    row.evaluation = evaluation::evaluate_disparity(map, loaded.truth, how);
    row.filled_percent = percent_filled(map);
    return row;
}

// Prints the head of the table and begins the JSON document.
Json begin(const MatchOptions& options, const std::vector<job::BackendPointer>& backends, int threads,
           const std::vector<std::string>& left_out, std::ostream& out) {
    Json json;
    json["schema"] = 1;
    json["version"] = HEXRELIEF_VERSION;
    json["threads"] = threads;
    json["backends"] = Json::array();
    for (const job::BackendPointer& backend : backends) {
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
    if (const match::Disturbance& d = options.disturbance;
        d.noise_percent != 0 || d.gamma != 1 || d.gain != 1)
        out << format("Noise of %g %% on both images, gamma %g and gain %g on the right one.\n",
                      d.noise_percent, d.gamma, d.gain);
    for (const std::string& name : left_out) out << "left out: " << name << '\n';
    out << "Seconds of the whole disparity stage, median of " << options.runs
        << ". edge: near true discontinuities, on the wrong side or unknown.\n"
        << match::headings() << std::flush;
    return json;
}

}  // namespace

void run_bench_match(const MatchOptions& options, std::ostream& out) {
    if (options.runs < 1) throw Error(ErrorKind::usage, "--runs: must be at least 1");
    config::Config config;
    for (const std::string& setting : options.settings) config::apply_setting(config, setting);
    match::check_disturbance(options.disturbance);
    const int threads = job::effective_threads(options.threads);
    const std::vector<job::BackendPointer> backends = usable_backends(threads);
    const std::vector<Method> methods = chosen(all_methods(backends), options.methods, "--methods");
    std::vector<std::string> left_out;
    const std::vector<match::ScenePair> found = match::find_scenes(options.data, left_out);
    if (found.empty())
        throw Error(ErrorKind::input, "--data " + options.data.string() +
                                          ": no folder below it holds left.*, right.* and disp.*");
    const std::vector<match::ScenePair> scenes = chosen(found, options.scenes, "--scenes");
    if (!options.json.empty()) files::check_writable_file(options.json);

    Json json = begin(options, backends, threads, left_out, out);
    std::vector<match::Row> rows;
    for (const match::ScenePair& scene : scenes) {
        const LoadedScene loaded = load(scene, options.disturbance);
        for (const Method& method : methods) {
            // The first call on a device also creates its context, which belongs to no scene.
            if (rows.size() < methods.size() && method.backend != "cpu")
                method.match(loaded.pair, config.disparity, threads);
            rows.push_back(measure(scene, loaded, method, config.disparity, options, threads));
            out << match::row_text(rows.back()) << std::flush;
            json["rows"].push_back(match::row_json(rows.back()));
        }
    }
    out << '\n';
    for (const match::Average& average : match::averages(rows)) {
        out << match::average_text(average);
        json["means"].push_back(match::average_json(average));
    }
    write_json(options.json, json);
}

}  // namespace hexrelief::bench
