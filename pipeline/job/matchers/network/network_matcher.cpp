#include "pipeline/job/matchers/network/network_matcher.h"

#include <algorithm>
#include <new>
#include <regex>
#include <utility>

#include "exporters/images/resize.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::job {
namespace {

constexpr int kCollar_px = 32;              // of a tile, that networks need to see around a pixel
constexpr long long kMostPixels = 1 << 26;  // of the pictures that a network is given
constexpr int kFloat = 1, kUint8 = 2;       // ONNX's TensorProto.DataType

bool has(const std::string& name, const char* part) {
    return readers::codec::lower_case(name).find(part) != std::string::npos;
}

bool names_right(const std::string& name) {
    return has(name, "right") || name.ends_with('2') || readers::codec::lower_case(name).ends_with("_r");
}

std::string shape_text(const Tensor& tensor) {
    return joined(tensor.dims, "x", [](int dim) { return std::to_string(dim); });
}

// Returns the first plane of a tensor that holds a map, or a flow whose first plane is that along x.
struct Plane {
    int width = 0, height = 0;
    const float* values = nullptr;  // null = the tensor holds none
};
Plane plane_of(const Tensor& tensor) {
    if (tensor.dims.size() < 2) return {};
    std::size_t pixels = 1, planes = 1;
    for (std::size_t i = 0; i < tensor.dims.size(); ++i)
        (i + 2 < tensor.dims.size() ? planes : pixels) *=
            static_cast<std::size_t>(std::max(tensor.dims[i], 0));
    if (planes < 1 || planes > 2 || pixels == 0 || tensor.values.size() != planes * pixels) return {};
    return {tensor.dims.back(), tensor.dims[tensor.dims.size() - 2], tensor.values.data()};
}

int round_up(int value, int multiple) {
    return (value + multiple - 1) / multiple * multiple;
}

}  // namespace

// A window's maps, of the network's size.
struct NetworkMatcher::Maps {
    std::vector<float> disparities, confidence;
};

std::vector<NetworkWindow> windows_of(int length, int side, int before, int after) {
    if (length <= side) return {{0, 0, length}};
    if (4LL * (side - before - after) < side) return {};
    std::vector<NetworkWindow> windows;
    for (int kept = 0; kept < length;) {
        const int first = std::min(std::max(0, kept - before), length - side);
        const int end = first + side == length ? length : first + side - after;
        windows.push_back({first, kept, end});
        kept = end;
    }
    return windows;
}

std::string operator_in(const std::string& words) {
    // OpenCV says the first, ONNX Runtime the others, by what is wrong.
    static const std::regex phrases(
        R"(Node \[(\w+)@|implementation for (\w+)|No Op registered for (\w+)|[:.](\w+)\(-?\d+\) is not a )"
        R"(registered|Op \((\w+)\)|while running (\w+) node)");
    std::smatch found;
    if (!std::regex_search(words, found, phrases)) return {};
    return *std::find_if(found.begin() + 1, found.end(), [](const auto& part) { return part.matched; });
}

std::string reason_in(const std::string& words) {
    // OpenCV: "OpenCV(4.6.0) FILE:LINE: error: (-2:Unspecified error) REASON in function 'NAME'", also
    // nested.
    const std::string before = "error: (", after = " in function";
    const std::size_t last = words.rfind(before);
    const std::size_t from = last == std::string::npos ? last : words.find(") ", last);
    if (from == std::string::npos) return words;
    return words.substr(from + 2, words.find(after, from) - from - 2);
}

NetworkMatcher::NetworkMatcher(std::filesystem::path file, const std::string& kind, int threads)
    : file_(std::move(file)),
      model_(read_model_file(file_)),
      kind_(kind_of_model(file_, kind)),
      threads_(threads) {
    find_pictures();
    find_outputs();
}

void NetworkMatcher::refuse(const std::string& what) const {
    throw Error(ErrorKind::input, file_.string() + ": " + what);
}

void NetworkMatcher::find_pictures() {
    const std::vector<ModelPort>& inputs = model_.inputs;
    is_joined_ = inputs.size() == 1;
    if (inputs.size() > 2)
        refuse("the network has " + std::to_string(inputs.size()) +
               " inputs, and a matcher takes two pictures; match by disparity.worker");
    for (const ModelPort& input : inputs) {
        const std::string name = "the network's input " + readers::codec::excerpt(input.name);
        if (input.dims.size() != 4) refuse(name + " is no picture (1 x channels x height x width)");
        if (input.dims[0] > 1) refuse(name + " takes several pictures at once; export it with a batch of 1");
        if (input.type != kFloat && input.type != kUint8)
            refuse(name + " takes no 32-bit floats; export the network with those");
        const long long channels = input.dims[1] / (is_joined_ ? 2 : 1);
        if (input.dims[1] != 0 && channels != 1 && channels != 3)
            refuse(name + " has " + std::to_string(input.dims[1]) + " channels; pictures have " +
                   (is_joined_ ? "6 or 2 together" : "3 or 1"));
        if (is_joined_ && input.dims[1] == 0) refuse(name + " is one, and a matcher takes two pictures");
        if (input.dims[1] != 0) channels_ = static_cast<int>(channels);
        for (const std::size_t i : {2u, 3u})
            if (input.dims[i] != inputs[0].dims[i]) refuse("the network's two pictures differ in size");
    }
    if (inputs[0].dims[2] * inputs[0].dims[3] > kMostPixels)
        refuse("the network takes pictures of " + size_text(inputs[0].dims[3], inputs[0].dims[2]) +
               " px, which are too large to be run");
    is_right_first_ = !is_joined_ && names_right(inputs[0].name) && !names_right(inputs[1].name);
}

void NetworkMatcher::find_outputs() {
    std::vector<std::size_t> named, others;
    for (std::size_t i = 0; i < model_.outputs.size(); ++i) {
        const std::string& name = model_.outputs[i].name;
        if (has(name, "occ"))
            occlusion_ = static_cast<std::ptrdiff_t>(i);
        else if (has(name, "conf"))
            confidence_ = static_cast<std::ptrdiff_t>(i);
        else
            (has(name, "disp") || has(name, "flow") ? named : others).push_back(i);
    }
    disparity_ = named.empty() ? others : named;
}

NetworkMatcher::Size NetworkMatcher::size_for(int width, int height) const {
    const auto side = [&](long long fixed, int length) {
        return fixed > 0 ? static_cast<int>(fixed) : round_up(length, kind_.multiple);
    };
    return {side(model_.inputs[0].dims[3], width), side(model_.inputs[0].dims[2], height)};
}

std::vector<Tensor> NetworkMatcher::run_network(const std::vector<Tensor>& inputs, Size size) {
    try {
        if (!network_ || size.width != loaded_.width || size.height != loaded_.height) {
            network_.reset();
            std::vector<std::vector<int>> shapes;
            for (const Tensor& input : inputs) shapes.push_back(input.dims);
            network_ = load_network(model_, with_shapes(model_, shapes), threads_);
            loaded_ = size;
        }
        return network_->run(inputs);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        const std::string failed = operator_in(error.what());
        const std::string reason = readers::codec::excerpt(reason_in(error.what()));
        refuse(network_library() + " cannot run the network" +
               (failed.empty() ? "" : "'s operator " + readers::codec::excerpt(failed)) + ": " + reason +
               "; export it in another way, " + network_advice() + "or match by disparity.worker");
    }
}

NetworkMatcher::Maps NetworkMatcher::run(const StereoPair& pair, int x, int y, Size size) {
    const std::size_t plane = static_cast<std::size_t>(size.width) * size.height;
    const auto add_picture = [&](const Image& image, Tensor& to) {
        for (int channel = 0; channel < channels_; ++channel)
            for (int row = 0; row < size.height; ++row)
                for (int column = 0; column < size.width; ++column) {
                    // What lies beside the picture repeats its border.
                    const std::uint8_t* const pixel =
                        image.at(std::min(x + column, image.width - 1), std::min(y + row, image.height - 1));
                    const bool is_mean = channels_ == 1 && image.channels == 3;
                    const double level = is_mean ? (pixel[0] + pixel[1] + pixel[2]) / 3.0
                                                 : pixel[std::min(channel, image.channels - 1)];
                    const auto c = static_cast<std::size_t>(channel);
                    to.values.push_back(
                        static_cast<float>((level / kind_.divisor - kind_.mean[c]) / kind_.std[c]));
                }
    };
    std::vector<Tensor> inputs(is_joined_ ? 1 : 2);
    for (Tensor& input : inputs) {
        input.dims = {1, is_joined_ ? 2 * channels_ : channels_, size.height, size.width};
        input.values.reserve(plane * static_cast<std::size_t>(input.dims[1]));
    }
    add_picture(is_right_first_ ? pair.right : pair.left, inputs.front());
    add_picture(is_right_first_ ? pair.left : pair.right, inputs.back());
    const std::vector<Tensor> outputs = run_network(inputs, size);

    Plane best;
    std::string shapes;
    for (const std::size_t i : disparity_) {
        const Plane map = plane_of(outputs[i]);
        shapes += (shapes.empty() ? "" : ", ") + shape_text(outputs[i]);
        if (map.values && map.width >= best.width) best = map;
    }
    if (!best.values) refuse("the network's answer is no map of disparities, but " + shapes);
    // A map of fewer pixels has its own px.
    const auto enlarged = [&](const Plane& map, bool is_in_px) {
        const int by = map.width > 0 ? size.width / map.width : 0;
        if (by < 1 || by * map.width != size.width || by * map.height != size.height)
            refuse("the network's answer has " + size_text(map.width, map.height) + " px for pictures of " +
                   size_text(size.width, size.height));
        std::vector<float> values;
        values.reserve(plane);
        for (int row = 0; row < size.height; ++row)
            for (int column = 0; column < size.width; ++column)
                values.push_back(map.values[static_cast<std::size_t>(row / by) * map.width + column / by] *
                                 static_cast<float>(is_in_px ? by : 1));
        return values;
    };
    Maps maps{enlarged(best, true), {}};
    for (const std::ptrdiff_t at : {confidence_, occlusion_}) {
        if (at < 0) continue;
        const Plane map = plane_of(outputs[static_cast<std::size_t>(at)]);
        if (!map.values) refuse("the network's confidences or occlusions are no map");
        const std::vector<float> values = enlarged(map, false);
        const bool is_hidden = at == occlusion_ && !kind_.is_occlusion_visible;
        if (maps.confidence.empty()) maps.confidence.assign(plane, 1);
        for (std::size_t i = 0; i < plane; ++i) maps.confidence[i] *= is_hidden ? 1 - values[i] : values[i];
    }
    return maps;
}

NetworkAnswer NetworkMatcher::match_in_windows(const StereoPair& pair, int ndisp, Size size) {
    const int width = pair.left.width, height = pair.left.height;
    const std::vector<NetworkWindow> columns = windows_of(width, size.width, ndisp + kCollar_px, kCollar_px);
    const std::vector<NetworkWindow> rows = windows_of(height, size.height, kCollar_px, kCollar_px);
    NetworkAnswer answer;
    if (columns.empty() || rows.empty()) return answer;
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    answer.map = {width, height, std::vector<float>(pixels, kUnknownDisparity), {}};
    for (const NetworkWindow& row : rows)
        for (const NetworkWindow& column : columns) {
            const Maps maps = run(pair, column.first, row.first, size);
            if (!maps.confidence.empty()) answer.confidence.resize(pixels);
            for (int y = row.kept_first; y < row.kept_end; ++y)
                for (int x = column.kept_first; x < column.kept_end; ++x) {
                    const std::size_t to = static_cast<std::size_t>(y) * width + x;
                    const std::size_t from =
                        static_cast<std::size_t>(y - row.first) * size.width + (x - column.first);
                    const float d = maps.disparities[from];
                    answer.map.values[to] = DisparityMap::known(d) ? d : kUnknownDisparity;
                    if (!maps.confidence.empty()) answer.confidence[to] = maps.confidence[from];
                }
        }
    const std::size_t tiles = rows.size() * columns.size();
    if (tiles > 1)
        answer.told.push_back("the network takes " + size_text(size.width, size.height) +
                              " px: the pair is matched in " + std::to_string(tiles) + " tiles");
    else if (size.width != width || size.height != height)
        answer.told.push_back("the pair is padded to " + size_text(size.width, size.height) + " px");
    return answer;
}

NetworkAnswer NetworkMatcher::match_smaller(const StereoPair& pair, int ndisp, Size size) {
    const int width = pair.left.width, height = pair.left.height;
    const double by =
        std::max(static_cast<double>(width) / size.width, static_cast<double>(height) / size.height);
    const int less_width = std::clamp(static_cast<int>(width / by), 1, size.width);
    const int less_height = std::clamp(static_cast<int>(height / by), 1, size.height);
    NetworkAnswer small = match_in_windows({exporters::resized(pair.left, less_width, less_height),
                                            exporters::resized(pair.right, less_width, less_height)},
                                           ndisp, size);
    NetworkAnswer answer;
    answer.map = {width, height, {}, {}};
    const double factor = static_cast<double>(width) / less_width;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t from =
                static_cast<std::size_t>(static_cast<long long>(y) * less_height / height) * less_width +
                static_cast<std::size_t>(static_cast<long long>(x) * less_width / width);
            const float d = small.map.values[from];
            answer.map.values.push_back(DisparityMap::known(d) ? static_cast<float>(d * factor) : d);
            if (!small.confidence.empty()) answer.confidence.push_back(small.confidence[from]);
        }
    answer.told.push_back("the network takes " + size_text(size.width, size.height) +
                          " px, too few for tiles with disparities of up to " + std::to_string(ndisp) +
                          " px: the pair is made smaller, " + size_text(less_width, less_height) + " px");
    return answer;
}

NetworkAnswer NetworkMatcher::match(const StereoPair& pair, int ndisp) {
    const Size size = size_for(pair.left.width, pair.left.height);
    if (static_cast<long long>(size.width) * size.height > kMostPixels)
        refuse("the pair's " + size_text(pair.left.width, pair.left.height) +
               " px are too many for a network; lower disparity.working_px");
    NetworkAnswer answer = match_in_windows(pair, ndisp, size);
    if (answer.map.values.empty()) answer = match_smaller(pair, ndisp, size);
    if (kind_.range_px > 0 && ndisp > kind_.range_px)
        answer.told.push_back("the network (" + kind_.name + ") finds disparities of up to " +
                              std::to_string(kind_.range_px) + " px, and up to " + std::to_string(ndisp) +
                              " are expected; lower disparity.working_px");
    return answer;
}

}  // namespace hexrelief::job
