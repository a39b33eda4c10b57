// Runs networks by ONNX Runtime.
#include <onnxruntime_cxx_api.h>

#include <algorithm>

#include "pipeline/job/matchers/network/network.h"

namespace hexrelief::job {
namespace {

class RuntimeNetwork final : public Network {
  public:
    RuntimeNetwork(const ModelFile& model, const std::vector<std::uint8_t>& file, int threads)
        : model_(model), session_(nullptr) {
        Ort::SessionOptions options;
        options.SetIntraOpNumThreads(threads);
        session_ = Ort::Session(environment_, file.data(), file.size(), options);
    }

    std::vector<Tensor> run(const std::vector<Tensor>& inputs) override {
        const Ort::MemoryInfo memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
        std::vector<std::vector<std::uint8_t>> levels(inputs.size());
        std::vector<Ort::Value> given;
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const std::vector<std::int64_t> dims(inputs[i].dims.begin(), inputs[i].dims.end());
            const std::vector<float>& values = inputs[i].values;
            if (model_.inputs[i].type == ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8) {
                levels[i].assign(values.begin(), values.end());
                given.push_back(Ort::Value::CreateTensor<std::uint8_t>(
                    memory, levels[i].data(), levels[i].size(), dims.data(), dims.size()));
            } else {
                given.push_back(Ort::Value::CreateTensor<float>(memory, const_cast<float*>(values.data()),
                                                                values.size(), dims.data(), dims.size()));
            }
        }
        const auto names_of = [](const std::vector<ModelPort>& ports) {
            std::vector<const char*> names;
            for (const ModelPort& port : ports) names.push_back(port.name.c_str());
            return names;
        };
        const std::vector<const char*> ins = names_of(model_.inputs), outs = names_of(model_.outputs);
        std::vector<Tensor> outputs;
        for (const Ort::Value& value :
             session_.Run({}, ins.data(), given.data(), given.size(), outs.data(), outs.size())) {
            const Ort::TensorTypeAndShapeInfo info = value.GetTensorTypeAndShapeInfo();
            Tensor tensor;
            for (const std::int64_t dim : info.GetShape()) tensor.dims.push_back(static_cast<int>(dim));
            if (info.GetElementType() == ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT)
                tensor.values.assign(value.GetTensorData<float>(),
                                     value.GetTensorData<float>() + info.GetElementCount());
            outputs.push_back(std::move(tensor));
        }
        return outputs;
    }

  private:
    const ModelFile& model_;
    // Its warnings would be taken for the reason of a failure.
    Ort::Env environment_{ORT_LOGGING_LEVEL_FATAL, "hexrelief"};
    Ort::Session session_;
};

}  // namespace

std::unique_ptr<Network> load_network(const ModelFile& model, const std::vector<std::uint8_t>& file,
                                      int threads) {
    return std::make_unique<RuntimeNetwork>(model, file, threads);
}

std::string network_library() {
    return "ONNX Runtime " + Ort::GetVersionString();
}

std::string network_advice() {
    return "";
}

}  // namespace hexrelief::job
