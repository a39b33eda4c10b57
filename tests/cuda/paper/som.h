// The paper's own GPU program (section 5, Algorithms 1 and 2), as close to its text as possible: the
// baseline of `bench_paper`. Its threads race, so its result differs from run to run; only the
// benchmark may use it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::paper {

// Section 5.2.2: one kernel, or one each for extraction, search and learning.
enum class Kernels { single, multiple };

// Fig. 7: a cell's neuron identifiers are interleaved with those of all other cells, or side by side; the
// latter also with the positions that learning reads bound to a texture.
enum class Memory { version1, version2, version2_texture };

struct Config {
    Kernels kernels = Kernels::single;
    Memory memory = Memory::version2_texture;
    // Threads of a block, 1..1024; `block_single` for the single kernel, the others for the multiple ones.
    int block_single = 32, block_extraction = 32, block_search = 32, block_learning = 32;
    double spacing_px = 6;  // g
    int t_max = 1500;
    double alpha_init = 1, alpha_final = 0.01, sigma_init = 12, sigma_final = 1;
    int co = 20;
    double delta = 1;
    int ssr = 3;                  // spiral search range; 0 = unlimited
    int crr = 20;                 // cell_refresh_rate
    int neurons_per_cell = 2000;  // Table 1: further neurons of a cell are not found until the next refresh
    // memory_reuse_set_rate: number of iterations for which random numbers are drawn at a time
    int random_reuse = 1000;
    std::uint64_t seed = 1;
    bool time_kernels = false;  // puts an event around each kernel, which takes some time itself
};

struct Result {
    HexMesh2D mesh;    // positions outside the image are moved onto its border
    double som_s = 0;  // lines 5 to 14 of Algorithm 1 by the device's clock
    // With time_kernels, each kernel's time over all iterations; with the single kernel, all of
    // it is in `single_s`.
    double single_s = 0, extraction_s = 0, search_s = 0, learning_s = 0;
    long long escaped = 0;  // vertices that had left the image
    std::size_t device_bytes = 0;
};

// Keeps its stream and memory from run to run. Must not be used by two threads at once.
class Som {
  public:
    Som();  // uses the current device; throws Error(device)
    ~Som();
    // Trains a lattice on the density and returns its mesh. Throws Error(usage) for an image of fewer than
    // three spacings or a block size out of range, and Error(device) if memory is too small.
    Result train(const DensityMap& density, const Config& config);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief::paper
