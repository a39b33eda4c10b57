// One run of the mesh stage on the device: its plans on the host, its memory on the device, and its steps in
// order; and the balancing of a part of a lattice.
#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>
#include <vector>

#include "cuda/balance/balance.h"
#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/staging.h"
#include "cuda/som/level.h"
#include "cuda/som/untangle.h"
#include "mesher/balance/balance.h"
#include "mesher/common/mesh_config.h"
#include "mesher/som/level_plan.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::cuda {

// Measures device time between pairs of events, one pair per level.
class LevelTimer {
  public:
    LevelTimer() = default;
    LevelTimer(const LevelTimer&) = delete;
    LevelTimer& operator=(const LevelTimer&) = delete;
    ~LevelTimer();
    void begin(cudaStream_t stream, std::size_t level) { record(stream, 2 * level); }
    void end(cudaStream_t stream, std::size_t level) { record(stream, 2 * level + 1); }
    // Returns the total time of the first `levels` levels, all of which must be over.
    double seconds(std::size_t levels) const;

  private:
    void record(cudaStream_t stream, std::size_t index);

    std::vector<cudaEvent_t> events_;
};

class MeshJob {
  public:
    // Plans the run and takes all its device memory from the arena, so that too little memory is noticed
    // before anything runs. magnification: the result of magnification_table(config.magnification). It,
    // density and config must outlive the job. Throws Error(device) if memory is too small, a radius exceeds
    // kMostRadius, or an image side exceeds 32,767 px.
    MeshJob(const Launch& launch, Arena& arena, const DensityMap& density, const MeshConfig& config,
            const std::vector<float>& magnification);

    // The steps, in this order. untangle() and download() wait for the device, the others do not.
    void upload(Staging& staging);
    void build_pyramids();
    void solve_levels(LevelTimer& balance_timer, const ProgressFunction& progress);
    void untangle();
    void move_to_area();
    HexMesh2D download(Staging& staging);

    std::size_t levels() const { return plans_.size(); }
    int iterations() const;  // number in all levels

  private:
    struct Level {
        LevelView view;
        int ahead;  // iterations whose points are drawn together
    };

    const som::LevelPlan& finest() const { return plans_.back(); }
    std::vector<float*> take_pyramid(std::size_t count);
    void take_levels();
    LevelView shared_view();
    LevelView level_view(const LevelView& shared, const som::LevelPlan& plan,
                         const std::uint32_t* tables) const;
    int draws_ahead(const som::LevelPlan& plan, const LevelView& view) const;
    void coarsen_all(const std::vector<float*>& pyramid);
    void initialise(std::size_t level, const float* masses);
    void train(std::size_t level, const float* weights);

    const Launch& launch_;
    Arena& arena_;
    const DensityMap& density_;
    const MeshConfig& config_;
    const std::vector<float>& magnification_;
    const som::MeshArea area_;
    const std::vector<som::LevelPlan> plans_;  // coarsest first
    const som::MeshOutline outline_;
    int longest_ = 1;                   // longest batch of all levels, in iterations
    std::vector<std::uint32_t> words_;  // the outline's curves, then the levels' learning tables
    // On the device:
    std::vector<float*> densities_;  // densities of the levels, finest first, which balancing equalises
    std::vector<float*> weights_;    // sampling weights, from which points are drawn
    float* magnification_on_device_ = nullptr;
    BalanceBuffers balance_buffers_{};
    std::int64_t* margins_ = nullptr;  // scratch of place_equalised()
    std::uint32_t* tables_ = nullptr;  // copy of words_
    std::vector<Level> levels_;        // coarsest first
    uint4* records_ = nullptr;         // scratch of train_small()
    UntangleScratch untangle_scratch_{};
};

// Balances a part of a lattice, some of whose vertices are held, on the device. Runs balance::balance_patch.
// Resets the arena and takes its memory from it; leaves the patch unchanged if the device fails. Throws
// Error(device), also if memory is too small, and Error(usage) for more than kMostSweeps sweeps.
void balance_patch(const Launch& launch, Arena& arena, Staging& staging, const DensityMap& density,
                   const BalanceConfig& config, balance::LatticePatch& patch);

}  // namespace hexrelief::cuda
