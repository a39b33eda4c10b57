// A network that runs, by the library that this build has for it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/job/matchers/network/model_file.h"

namespace hexrelief::job {

struct Tensor {
    std::vector<int> dims;  // the last one varies fastest
    std::vector<float> values;
};

class Network {
  public:
    virtual ~Network() = default;
    // inputs: in the order of the model's. Returns its outputs, in their order. Throws any std::exception,
    // with the library's words.
    virtual std::vector<Tensor> run(const std::vector<Tensor>& inputs) = 0;
};

// file: the model's bytes, its inputs of these shapes. Throws any std::exception, with the library's words.
std::unique_ptr<Network> load_network(const ModelFile& model, const std::vector<std::uint8_t>& file,
                                      int threads);

// The library's name and version.
std::string network_library();

// What may help if it cannot run a network, beside those two that always may; empty = nothing.
std::string network_advice();

}  // namespace hexrelief::job
