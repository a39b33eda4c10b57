// What `hexrelief bench cuda` measures: the paper baseline, our program on the device and on the CPU.
#pragma once

#include <memory>
#include <string>

#include "cuda/paper/som.h"
#include "mesher/mesher.h"
#include "pipeline/bench/cuda_rows.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::cuda_bench {

struct Case {
    std::string map;  // its name
    DisparityMap disparity;
    DensityMap density;
};

// Our configuration for the paper baseline's schedule: Table 1 on one level, with a free border.
MeshConfig same_schedule(const paper::Config& config);

class Solvers {
  public:
    explicit Solvers(int threads);  // >= 1; throws Error(device) where no CUDA device is usable
    ~Solvers();
    std::string device() const;
    std::string cpu() const;

    // Each measures `runs` times, after one run that is not counted. The paper baseline makes none of those
    // where it runs at most three times. Its %cost differs from run to run: the median of the first three.
    Row paper(const Case& c, const paper::Config& config, int runs);
    Row ours(const Case& c, const std::string& solver, const MeshConfig& config, int runs);
    // The default's lattice cut along silhouettes, by CUDA: som_s is its kernels' time, stage_s that of the
    // whole call.
    Row cut_mesh(const Case& c, int runs);
    // One run, without the uncounted one.
    Row on_cpu(const Case& c, const MeshConfig& config);
    // Gives the paper baseline's memory back.
    void release();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief::cuda_bench
