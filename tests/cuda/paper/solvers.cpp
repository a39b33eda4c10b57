#include "tests/cuda/paper/solvers.h"

#include <utility>

#include "pipeline/data/clock.h"
#include "pipeline/job/backend.h"

namespace hexrelief::paper {

struct Solvers::State {
    int threads;
    job::BackendPointer cuda, cpu;
    std::unique_ptr<Som> som;
};

namespace {

constexpr int kMeasuredRuns = 3;

Row empty_row(const Case& c, const std::string& solver) {
    Row row;
    row.map = c.map;
    row.solver = solver;
    row.width = c.density.width;
    row.height = c.density.height;
    return row;
}

void add_quality(const Case& c, const HexMesh2D& mesh, int threads, Times& costs, Row& row) {
    const quality::MeshQuality quality = quality::measure_quality(mesh, c.density, threads);
    costs.runs.push_back(quality.percent_cost);
    row.percent_cost = costs.median();
    row.inverted = quality.inverted_triangles;
    row.columns = mesh.columns;
    row.rows = mesh.rows;
}

// Of MeshConfig and of Config alike.
void describe(const auto& config, Row& row) {
    row.co = config.co;
    row.ssr = config.ssr;
    row.crr = config.crr;
    row.sigma_init = config.sigma_init;
}

Row measure(const Case& c, const std::string& solver, job::Backend& backend, const MeshConfig& config,
            int runs, int threads) {
    Row row = empty_row(c, solver);
    describe(config, row);
    Times costs;
    for (int run = 0; run < runs; ++run) {
        backend.expect_map(c.disparity);
        const double start = now_seconds();
        const HexMesh2D mesh = backend.solve_mesh(c.density, config, {});
        row.stage_s.runs.push_back(now_seconds() - start);
        const DeviceFigures device = backend.figures();
        if (device.training_s > 0) row.som_s.runs.push_back(device.training_s);
        if (run > 0) continue;  // every run gives the same bytes
        row.iterations = mesh.iterations;
        row.device_bytes = device.bytes;
        add_quality(c, mesh, threads, costs, row);
    }
    return row;
}

void add_times(const Result& result, Row& row) {
    row.som_s.runs.push_back(result.som_s);
    const std::pair<const char*, double> kernels[] = {{"single", result.single_s},
                                                      {"extraction", result.extraction_s},
                                                      {"search", result.search_s},
                                                      {"learning", result.learning_s}};
    for (const auto& [kernel, seconds] : kernels)
        if (seconds > 0) row.kernels[kernel].runs.push_back(seconds);
}

}  // namespace

MeshConfig same_schedule(const Config& config) {
    MeshConfig same{.spacing_px = config.spacing_px,
                    .levels = 1,
                    .t_max = config.t_max,
                    .alpha_init = config.alpha_init,
                    .alpha_final = config.alpha_final,
                    .sigma_init = config.sigma_init,
                    .sigma_final = config.sigma_final,
                    .co = config.co,
                    .delta = config.delta,
                    .ssr = config.ssr,
                    .crr = config.crr};
    same.prr_final = 100;  // as in config/paper.yaml
    same.magnification = 1;
    same.border = MeshBorder::free;
    same.balance.enabled = false;
    return same;
}

Solvers::Solvers(int threads) : state_(std::make_unique<State>()) {
    state_->threads = threads;
    state_->cuda = job::pick_backend(config::BackendChoice::cuda, threads);
    state_->cpu = job::pick_backend(config::BackendChoice::cpu, threads);
}

Solvers::~Solvers() = default;

std::string Solvers::device() const {
    return state_->cuda->device();
}
std::string Solvers::cpu() const {
    return state_->cpu->device();
}

Row Solvers::ours(const Case& c, const std::string& solver, const MeshConfig& config, int runs) {
    state_->cuda->expect_map(c.disparity);
    state_->cuda->solve_mesh(c.density, config, {});  // a first call, which is not timed
    return measure(c, solver, *state_->cuda, config, runs, state_->threads);
}

Row Solvers::cut_mesh(const Case& c, int runs) {
    state_->cuda->expect_map(c.disparity);
    const HexMesh2D lattice = state_->cuda->solve_mesh(c.density, {}, {});
    const surface::DisparityMeshInput input{&lattice, &c.disparity, c.density.background_px};
    Row row = empty_row(c, "cut");
    row.columns = lattice.columns;
    row.rows = lattice.rows;
    for (int run = -1; run < runs; ++run) {
        const double start = now_seconds();
        state_->cuda->cut_disparity_mesh(input, {});
        const double seconds = now_seconds() - start;
        if (run < 0) continue;
        row.stage_s.runs.push_back(seconds);
        row.som_s.runs.push_back(state_->cuda->figures().surface_s);
        row.device_bytes = state_->cuda->figures().bytes;
    }
    return row;
}

Row Solvers::on_cpu(const Case& c, const MeshConfig& config) {
    return measure(c, "cpu", *state_->cpu, config, 1, state_->threads);
}

Row Solvers::paper(const Case& c, const Config& config, int runs) {
    if (!state_->som) state_->som = std::make_unique<Som>();
    Row row = empty_row(c, "paper");
    describe(config, row);
    row.baseline = config;
    row.iterations = config.t_max;
    Times costs;
    for (int run = runs > kMeasuredRuns ? -1 : 0; run < runs; ++run) {
        const double start = now_seconds();
        const Result result = state_->som->train(c.density, config);
        if (run < 0) continue;
        row.stage_s.runs.push_back(now_seconds() - start);
        add_times(result, row);
        if (run >= kMeasuredRuns) continue;
        row.device_bytes = result.device_bytes;
        row.escaped = result.escaped;
        add_quality(c, result.mesh, state_->threads, costs, row);
    }
    return row;
}

void Solvers::release() {
    state_->som.reset();
}

}  // namespace hexrelief::paper
