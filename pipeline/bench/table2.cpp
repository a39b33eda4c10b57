#include "pipeline/bench/table2.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>

#include "mesher/mesher.h"
#include "pipeline/bench/backends.h"
#include "pipeline/bench/maps.h"
#include "pipeline/bench/table2_paper.h"
#include "pipeline/bench/table2_rows.h"
#include "pipeline/config/options.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "pipeline/stages/density.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;
using namespace table2;
using Json = nlohmann::ordered_json;

// The paper's S maps; the sequential method takes a second for them.
constexpr long long kSmallMap_px = 250000;

const std::vector<std::string> kMethods{"sequential", "paper", "som", "default"};

// Returns Table 1 with section 6.4's radius, one level, on the paper's free border: used by both of
// the paper's own methods.
MeshConfig paper_schedule(int ssr) {
    MeshConfig config;
    config.levels = 1;
    config.t_max = 1500;
    config.alpha_init = 1;
    config.alpha_final = 0.01;
    config.sigma_init = 12;
    config.sigma_final = 1;
    config.co = 20;
    config.delta = 1;
    config.ssr = ssr;
    config.crr = 20;
    config.prr = 5;
    config.prr_final = 100;
    config.magnification = 1;
    config.border = MeshBorder::free;
    config.balance.enabled = false;
    return config;
}

struct LoadedMap {
    DisparityMap disparity;
    DensityMap density;  // of the method that is measured
};

struct Method {
    std::string name;
    MeshConfig mesh;
    stages::DensityConfig density;
};

// True for the sequential method, which only exists on the CPU.
bool needs_cpu(const std::string& method) {
    return method == "sequential";
}

int runs_of(const Table2Options& options, const std::string& method, const LoadedMap& map) {
    if (method != "sequential") return options.runs;
    if (options.sequential_runs > 0) return options.sequential_runs;
    const bool small = static_cast<long long>(map.density.width) * map.density.height <= kSmallMap_px;
    return small ? options.runs : 1;
}

double seconds_of(const std::function<void()>& work) {
    const double start = now_seconds();
    work();
    return now_seconds() - start;
}

// Runs the whole surface stage in its default configuration. The camera does not matter: only
// the time is measured.
void lay_surface(const HexMesh2D& mesh, const LoadedMap& map, int threads) {
    const int width = map.disparity.width, height = map.disparity.height;
    const Calibration camera{double(width), 0.5 * width, 0.5 * height, 1, 0, false, 0, 0};
    const DisparityMesh cut_mesh =
        surface::cut_disparity_mesh({&mesh, &map.disparity, map.density.background_px, nullptr}, {}, threads);
    // The paper's schedule may leave a tiny map's lattice mirrored, with no triangle to keep.
    if (!cut_mesh.triangles.empty()) stages::build_surface(cut_mesh, width, height, camera, 0);
}

Row measure(const bench::table2::PaperMap& paper, const LoadedMap& map, const Method& method,
            job::Backend& backend, int runs, int threads) {
    const MeshConfig& config = method.mesh;
    const auto cells = [&](int pixels) { return (pixels + config.co - 1) / config.co; };
    table2::Row row;
    row.paper = &paper;
    row.method = method.name;
    row.backend = backend.name();
    row.width = map.density.width;
    row.height = map.density.height;
    row.cell_columns = cells(row.width);
    row.cell_rows = cells(row.height);
    row.ssr = config.ssr;
    row.crr = config.crr;
    for (int run = 0; run < runs; ++run) {
        HexMesh2D mesh;
        backend.expect_map(map.disparity);
        row.mesh.runs.push_back(seconds_of([&] { mesh = backend.solve_mesh(map.density, config, {}); }));
        row.surface.runs.push_back(seconds_of([&] { lay_surface(mesh, map, threads); }));
        if (run > 0) continue;  // same seed, same mesh
        row.columns = mesh.columns;
        row.rows = mesh.rows;
        row.iterations = mesh.iterations;
        row.quality = quality::measure_quality(mesh, map.density, threads);
    }
    std::sort(row.mesh.runs.begin(), row.mesh.runs.end());
    std::sort(row.surface.runs.begin(), row.surface.runs.end());
    return row;
}

// Makes the first call on a device, whose start must not count for any map.
void warm_up(job::Backend& backend, const LoadedMap& map) {
    MeshConfig config;
    config.t_max = 1;
    config.balance.enabled = false;
    backend.expect_map(map.disparity);
    backend.solve_mesh(map.density, config, {});
}

}  // namespace

stages::DensityConfig paper_density() {
    stages::DensityConfig config;
    config.scale_percentile = 100;
    config.background_method = stages::BackgroundMethod::fraction;
    config.floor = 0;
    return config;
}

MeshConfig method_config(const std::string& method, int ssr) {
    MeshConfig config;
    config.balance.enabled = false;
    if (method == "som") {  // config/som.yaml
        config.t_max = 60;
        config.prr = 2;
        config.prr_final = 10;
        config.magnification = 1.3;
        config.border = MeshBorder::slide;
        return config;
    }
    config = paper_schedule(ssr);
    if (method == "sequential") config.method = MeshMethod::sequential;
    return config;
}

void run_bench_table2(const Table2Options& options, std::ostream& out) {
    if (options.runs < 1) throw Error(ErrorKind::usage, "--runs: must be at least 1");
    check_names(options.methods, kMethods, "--methods");
    const config::Config own = config::read_config({}, options.settings);
    std::vector<std::string> missing;
    const std::vector<FoundMap> found = find_maps(options.data, {}, options.maps, missing);
    if (!options.json.empty()) files::check_writable_file(options.json);
    const int threads = job::effective_threads(options.threads);
    const std::vector<job::BackendPointer> backends = usable_backends(threads);

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
    for (const std::string& name : missing) out << "not there, left out: " << name << '\n';
    json["missing"] = missing;
    out << "Seconds of the mesh stage, and of the surface stage on the CPU. sequential, paper: the paper's "
           "schedule; default: this "
           "program's own, on its own density; som: that without its balancing. The others are on the "
           "paper's density.\n"
        << table2::headings() << std::flush;

    bool warm = false;
    std::vector<table2::Row> rows;
    json["rows"] = Json::array();
    json["averages"] = Json::array();
    for (std::size_t i = 0; i < found.size(); ++i) {
        LoadedMap map{load_map(found[i]), {}};
        for (const std::string& name : kMethods) {
            if (!wanted(options.methods, name)) continue;
            const Method method = name == "default"
                                      ? Method{name, own.mesh, own.density}
                                      : Method{name, method_config(name, found[i].map->ssr), paper_density()};
            map.density = stages::compute_density(map.disparity, method.density);
            for (const job::BackendPointer& backend : backends) {
                const bool is_cpu = backend->name() == "cpu";
                if (!is_cpu && needs_cpu(name)) continue;
                if (!is_cpu && !warm) warm_up(*backend, map);
                warm |= !is_cpu;
                rows.push_back(
                    measure(*found[i].map, map, method, *backend, runs_of(options, name, map), threads));
                out << row_text(rows.back()) << std::flush;
                json["rows"].push_back(row_json(rows.back()));
            }
        }
        const std::string set = found[i].map->set;
        if (i + 1 < found.size() && found[i + 1].map->set == set) continue;
        for (const table2::Average& average : table2::averages(rows, set)) {
            out << table2::average_text(average);
            json["averages"].push_back(table2::average_json(average));
        }
        out << '\n' << std::flush;
    }
    write_json(options.json, json);
}

}  // namespace hexrelief::bench
