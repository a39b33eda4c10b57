// The solvers that `bench_paper` measures: the paper baseline, our program on the device
// and on the CPU.
#pragma once

#include <memory>
#include <string>

#include "mesher/mesher.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "tests/cuda/paper/rows.h"
#include "tests/cuda/paper/som.h"

namespace hexrelief::paper {

// A map to be meshed.
struct Case {
    std::string map;  // its name
    DisparityMap disparity;
    DensityMap density;
};

// Returns our configuration with the paper baseline's schedule: Table 1 on one level, with a free border.
MeshConfig same_schedule(const Config& config);

class Solvers {
  public:
    explicit Solvers(int threads);  // >= 1; throws Error(device) if no CUDA device is usable
    ~Solvers();
    std::string device() const;
    std::string cpu() const;

    // Measure `runs` runs, after one that is not counted; the paper baseline has no such run if `runs` is at
    // most three. Its %cost differs from run to run: the median of the first three is taken.
    Row paper(const Case& c, const Config& config, int runs);
    Row ours(const Case& c, const std::string& solver, const MeshConfig& config, int runs);
    // Measures cutting the default configuration's lattice along silhouettes by CUDA: som_s is the kernels'
    // time, stage_s that of the whole call.
    Row cut_mesh(const Case& c, int runs);
    // Measures one run, without an uncounted one before.
    Row on_cpu(const Case& c, const MeshConfig& config);
    // Frees the paper baseline's memory.
    void release();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief::paper
