// Runs networks by OpenCV's dnn.
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>

#include "pipeline/job/matchers/network/network.h"

namespace hexrelief::job {
namespace {

class OpencvNetwork final : public Network {
  public:
    OpencvNetwork(const ModelFile& model, const std::vector<std::uint8_t>& file)
        : net_(cv::dnn::readNetFromONNX(file)) {
        for (const ModelPort& port : model.inputs) inputs_.push_back(port.name);
        for (const ModelPort& port : model.outputs) outputs_.push_back(port.name);
        net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
        net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    }

    std::vector<Tensor> run(const std::vector<Tensor>& inputs) override {
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const cv::Mat blob(inputs[i].dims, CV_32F, const_cast<float*>(inputs[i].values.data()));
            net_.setInput(blob, inputs_[i]);
        }
        std::vector<cv::Mat> blobs;
        net_.forward(blobs, outputs_);
        std::vector<Tensor> outputs;
        for (const cv::Mat& blob : blobs) {
            cv::Mat floats;
            blob.convertTo(floats, CV_32F);
            if (!floats.isContinuous()) floats = floats.clone();
            outputs.push_back(
                {std::vector<int>(floats.size.p, floats.size.p + floats.dims),
                 std::vector<float>(floats.ptr<float>(), floats.ptr<float>() + floats.total())});
        }
        return outputs;
    }

  private:
    cv::dnn::Net net_;
    std::vector<std::string> inputs_, outputs_;
};

}  // namespace

std::unique_ptr<Network> load_network(const ModelFile& model, const std::vector<std::uint8_t>& file,
                                      int threads) {
    cv::setNumThreads(threads);
    return std::make_unique<OpencvNetwork>(model, file);
}

std::string network_library() {
    return "OpenCV " + cv::getVersionString();
}

std::string network_advice() {
    return "build hexrelief with ONNX Runtime, ";
}

}  // namespace hexrelief::job
