// Backends that do what a test needs of a device.
#pragma once

#include "pipeline/data/error.h"
#include "pipeline/job/backend.h"

namespace hexrelief::test {

// The CPU under another name, whose work each test changes.
class TestedBackend : public job::Backend {
  public:
    TestedBackend() : Backend(1) {}
    std::string name() const override { return "cuda"; }
    std::string device() const override { return "a test's"; }
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config) override {
        return cpu_->match_pair(pair, config);
    }
    HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config,
                         const ProgressFunction& progress) override {
        return cpu_->solve_mesh(density, config, progress);
    }
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                     const SurfaceConfig& config) override {
        return cpu_->cut_disparity_mesh(input, config);
    }
    void balance_patch(const DensityMap& density, const BalanceConfig& config,
                       balance::LatticePatch& patch) override {
        cpu_->balance_patch(density, config, patch);
    }

  private:
    job::BackendPointer cpu_ = job::pick_backend(config::BackendChoice::cpu, 1);
};

// Has a device's clock: each cut takes a second more than the one before.
class ClockedBackend final : public TestedBackend {
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                     const SurfaceConfig& config) override {
        ++cuts_;
        return TestedBackend::cut_disparity_mesh(input, config);
    }
    DeviceFigures figures() const override { return {.surface_s = static_cast<double>(cuts_)}; }
    int cuts_ = 0;
};

enum class Fails { matching, solving, cutting };

class FailingBackend final : public TestedBackend {
  public:
    explicit FailingBackend(Fails when, ErrorKind kind = ErrorKind::device) : when_(when), kind_(kind) {}

  private:
    void fail_if(Fails when) const {
        if (when == when_) throw Error(kind_, "backend cuda: training: unspecified launch failure");
    }
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config) override {
        fail_if(Fails::matching);
        return TestedBackend::match_pair(pair, config);
    }
    HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config,
                         const ProgressFunction& progress) override {
        progress(0.5);
        fail_if(Fails::solving);
        return TestedBackend::solve_mesh(density, config, progress);
    }
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                     const SurfaceConfig& config) override {
        fail_if(Fails::cutting);
        return TestedBackend::cut_disparity_mesh(input, config);
    }
    Fails when_;
    ErrorKind kind_;
};

}  // namespace hexrelief::test
