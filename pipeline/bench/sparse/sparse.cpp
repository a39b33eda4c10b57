#include "pipeline/bench/sparse/sparse.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>

#include "pipeline/bench/bench_rows.h"
#include "pipeline/bench/maps.h"
#include "pipeline/bench/match/match_scenes.h"
#include "pipeline/bench/rd_meshes.h"
#include "pipeline/bench/sparse/patterns.h"
#include "pipeline/config/options.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/densify/densify.h"
#include "pipeline/dequantize/dequantize.h"
#include "pipeline/dequantize/quantum.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/backend.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/stages/density.h"
#include "pipeline/stages/surface_quality.h"

namespace hexrelief::bench {
namespace {

using match::ScenePair;
using Json = nlohmann::ordered_json;

struct Row {
    std::string scene, pattern;
    double known_share = 0, seconds = 0;
    stages::SurfaceQuality quality = {};
    double ratio = 1;                           // to the whole map's error
    double wrong_share = 0, unknown_share = 0;  // of the true map's pixels: more than 1 px off; not filled
};

// One true map, and the settings by which its surfaces are measured.
struct TrueScene {
    std::string name;
    DisparityMap truth;
    Image left;  // may be empty
    double quantum_px;
    const config::Config& config;
    int threads;
    float background_px = stages::compute_density(truth, config.density).background_px;

    stages::SurfaceQuality measure(const DisparityMap& map) const {
        const bool smooths = config.disparity.dequantize != stages::Dequantization::none && quantum_px > 0;
        const DisparityMap meshed = smooths ? dequantize::dequantize(map, quantum_px, threads) : map;
        return stages::measure_surface_quality(rd::preset_mesh(meshed, config, threads), truth, background_px,
                                               threads);
    }
};

double known_share(const DisparityMap& map) {
    const auto known = std::count_if(map.values.begin(), map.values.end(), DisparityMap::known);
    return static_cast<double>(known) / static_cast<double>(map.values.size());
}

Row measure(const TrueScene& scene, const std::string& pattern, const stages::SurfaceQuality& whole) {
    const DisparityMap thin = sparse::thinned(scene.truth, pattern);
    Row row{scene.name, pattern, known_share(thin)};
    const double begun = now_seconds();
    const DisparityMap dense = densify::densify(thin, scene.left, scene.threads);
    row.seconds = now_seconds() - begun;
    row.quality = scene.measure(dense);
    row.ratio = row.quality.duo_rmse_near_px / whole.duo_rmse_near_px;
    double true_pixels = 0;
    for (std::size_t i = 0; i < dense.values.size(); ++i) {
        if (!DisparityMap::known(scene.truth.values[i])) continue;
        ++true_pixels;
        if (!DisparityMap::known(dense.values[i]))
            ++row.unknown_share;
        else
            row.wrong_share += std::abs(dense.values[i] - scene.truth.values[i]) > 1;
    }
    row.wrong_share /= true_pixels;
    row.unknown_share /= true_pixels;
    return row;
}

std::string headings() {
    return format("%-16s %-10s %7s %7s %9s %7s %7s %6s %7s\n", "scene", "pattern", "known %", "wrong %",
                  "unknown %", "duo px", "flat px", "ratio", "s");
}

std::string row_text(const Row& row) {
    return format("%-16s %-10s %7.1f %7.2f %9.2f %7.3f %7.3f %6.2f %7.3f\n", row.scene.c_str(),
                  row.pattern.c_str(), 100 * row.known_share, 100 * row.wrong_share, 100 * row.unknown_share,
                  row.quality.duo_rmse_near_px, row.quality.flat_rmse_px, row.ratio, row.seconds);
}

Json row_json(const Row& row) {
    Json json;
    json["scene"] = row.scene;
    json["pattern"] = row.pattern;
    json["known_share"] = row.known_share;
    json["wrong_share"] = row.wrong_share;
    json["unknown_share"] = row.unknown_share;
    json["duo_rmse_near_px"] = row.quality.duo_rmse_near_px;
    json["flat_rmse_px"] = row.quality.flat_rmse_px;
    json["ratio"] = row.ratio;
    json["seconds"] = row.seconds;
    return json;
}

std::string mean_text(const std::vector<Row>& rows, const std::string& pattern) {
    double logarithms = 0, worst = 0;
    int count = 0;
    for (const Row& row : rows) {
        if (row.pattern != pattern) continue;
        logarithms += std::log(row.ratio);
        worst = std::max(worst, row.ratio);
        ++count;
    }
    if (count == 0) return {};
    return format("%-16s %-10s geometric mean of %d ratios %.2f, largest %.2f\n", "", pattern.c_str(), count,
                  std::exp(logarithms / count), worst);
}

TrueScene load(const ScenePair& found, const config::Config& config, bool without_picture, int threads) {
    readers::DisparityFileConfig file;
    file.scale = found.scale;
    DisparityMap truth = readers::read_disparity_map(found.truth, file);
    const double quantum_px = dequantize::find_quantum_px(truth);
    return {found.name, std::move(truth), without_picture ? Image{} : readers::read_image(found.left),
            quantum_px, config,           threads};
}

std::vector<ScenePair> chosen_scenes(const SparseOptions& options, std::ostream& out) {
    std::vector<std::string> left_out, names;
    std::vector<ScenePair> found = match::find_scenes(options.data, left_out), chosen;
    for (const std::string& name : left_out) out << "left out: " << name << '\n';
    for (const ScenePair& scene : found) names.push_back(scene.name);
    check_names(options.scenes, names, "--scenes");
    for (ScenePair& scene : found)
        if (wanted(options.scenes, scene.name)) chosen.push_back(std::move(scene));
    if (chosen.empty())
        throw Error(ErrorKind::input, "--data " + options.data.string() +
                                          ": no folder below it holds left.*, right.* and disp.*");
    return chosen;
}

}  // namespace

void run_bench_sparse(const SparseOptions& options, std::ostream& out) {
    check_names(options.patterns, sparse::patterns(), "--patterns");
    const config::Config config = config::read_config({options.preset}, options.settings);
    const int threads = job::effective_threads(options.threads);
    const std::vector<ScenePair> scenes = chosen_scenes(options, out);
    if (!options.json.empty()) files::check_writable_file(options.json);

    Json json;
    json["schema"] = 1;
    json["version"] = HEXRELIEF_VERSION;
    json["threads"] = threads;
    json["with_picture"] = !options.without_picture;
    json["rows"] = Json::array();
    std::vector<Row> rows;
    const auto add = [&](Row row) {
        out << row_text(row) << std::flush;
        json["rows"].push_back(row_json(row));
        rows.push_back(std::move(row));
    };
    out << "Errors of the surface against the whole true map. ratio: to the whole map's own duo.\n"
        << headings();
    for (const ScenePair& found : scenes) {
        const TrueScene scene = load(found, config, options.without_picture, threads);
        add({scene.name, "whole", known_share(scene.truth), 0, scene.measure(scene.truth)});
        const stages::SurfaceQuality whole = rows.back().quality;
        for (const std::string& pattern : sparse::patterns())
            if (wanted(options.patterns, pattern)) add(measure(scene, pattern, whole));
    }
    for (const std::string& pattern : sparse::patterns()) out << mean_text(rows, pattern);
    write_json(options.json, json);
}

}  // namespace hexrelief::bench
