#include "pipeline/job/matchers/network/model_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <span>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/files/sha256.h"
#include "pipeline/readers/source.h"

namespace hexrelief::job {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Numbers of fields of ONNX's messages (onnx.proto3), and of the wire's types.
namespace field {
constexpr std::uint64_t graph = 7;                                            // ModelProto
constexpr std::uint64_t initializer = 5, input = 11, output = 12;             // GraphProto
constexpr std::uint64_t value_name = 1, value_type = 2, tensor_type = 1;      // ValueInfoProto, TypeProto
constexpr std::uint64_t element_type = 1, shape = 2, dim = 1, dim_value = 1;  // TypeProto.Tensor, ...
constexpr std::uint64_t tensor_name = 8, data_location = 14;                  // TensorProto
}  // namespace field
constexpr std::uint64_t kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5;
constexpr std::uint64_t kExternal = 1;  // TensorProto.DataLocation
constexpr std::size_t kMostPorts = 64, kMostDims = 8;

struct NotOnnx {};

// The fields of a message, one after the other; their contents are looked at by whoever knows their type.
class Message {
  public:
    explicit Message(Bytes all) : rest_(all) {}

    // Goes to the next field. Returns false at the end; throws NotOnnx if the bytes are no message.
    bool next() {
        if (rest_.empty()) return false;
        const Bytes from = rest_;
        const std::uint64_t key = varint();
        number = key >> 3;
        value = 0, bytes = {};
        switch (key & 7) {
            case kVarint:
                value = varint();
                break;
            case kFixed64:
                take(8);
                break;
            case kFixed32:
                take(4);
                break;
            case kBytes:
                bytes = take(varint());
                break;
            default:
                throw NotOnnx();
        }
        whole = from.first(from.size() - rest_.size());
        return true;
    }

    std::uint64_t number = 0, value = 0;
    Bytes bytes, whole;  // the content of a field of bytes; the field with its number

  private:
    Bytes take(std::uint64_t count) {
        if (count > rest_.size()) throw NotOnnx();
        const Bytes taken = rest_.first(static_cast<std::size_t>(count));
        rest_ = rest_.subspan(taken.size());
        return taken;
    }
    std::uint64_t varint() {
        std::uint64_t number_read = 0;
        for (unsigned shift = 0; shift < 64; shift += 7) {
            const std::uint8_t byte = take(1)[0];
            number_read |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
            if ((byte & 0x80) == 0) return number_read;
        }
        throw NotOnnx();
    }

    Bytes rest_;
};

std::string text_of(Bytes bytes) {
    return {bytes.begin(), bytes.end()};
}

void read_shape(Bytes bytes, std::vector<long long>& dims) {
    for (Message shape(bytes); shape.next();) {
        if (shape.number != field::dim) continue;
        if (dims.size() == kMostDims) throw NotOnnx();
        dims.push_back(0);
        for (Message dim(shape.bytes); dim.next();)
            if (dim.number == field::dim_value && dim.value <= INT32_MAX)
                dims.back() = static_cast<long long>(dim.value);
    }
}

ModelPort read_port(Bytes bytes) {
    ModelPort port;
    for (Message value(bytes); value.next();) {
        if (value.number == field::value_name) port.name = text_of(value.bytes);
        if (value.number != field::value_type) continue;
        for (Message type(value.bytes); type.next();) {
            if (type.number != field::tensor_type) continue;
            for (Message tensor(type.bytes); tensor.next();) {
                if (tensor.number == field::element_type) port.type = static_cast<int>(tensor.value & 0xff);
                if (tensor.number == field::shape) read_shape(tensor.bytes, port.dims);
            }
        }
    }
    return port;
}

struct Graph {
    std::vector<ModelPort> inputs, outputs;
    std::set<std::string> initializers;
    bool has_other_files = false;
};

void read_graph(Bytes bytes, Graph& graph) {
    const auto add = [](std::vector<ModelPort>& ports, Bytes port) { ports.push_back(read_port(port)); };
    for (Message part(bytes); part.next();) {
        if (part.number == field::input) add(graph.inputs, part.bytes);
        if (part.number == field::output) add(graph.outputs, part.bytes);
        if (part.number != field::initializer) continue;
        for (Message tensor(part.bytes); tensor.next();) {
            if (tensor.number == field::tensor_name) graph.initializers.insert(text_of(tensor.bytes));
            if (tensor.number == field::data_location && tensor.value == kExternal)
                graph.has_other_files = true;
        }
    }
}

void append_varint(std::vector<std::uint8_t>& to, std::uint64_t value) {
    for (; value > 0x7f; value >>= 7) to.push_back(static_cast<std::uint8_t>(value | 0x80));
    to.push_back(static_cast<std::uint8_t>(value));
}

void append_number(std::vector<std::uint8_t>& to, std::uint64_t number, std::uint64_t value) {
    append_varint(to, number << 3 | kVarint);
    append_varint(to, value);
}

void append_bytes(std::vector<std::uint8_t>& to, std::uint64_t number, Bytes content) {
    append_varint(to, number << 3 | kBytes);
    append_varint(to, content.size());
    to.insert(to.end(), content.begin(), content.end());
}

std::vector<std::uint8_t> written(const ModelPort& port, const std::vector<int>& dims) {
    std::vector<std::uint8_t> shape, tensor, type, value;
    for (const int dim : dims) {
        std::vector<std::uint8_t> one;
        append_number(one, field::dim_value, static_cast<std::uint64_t>(dim));
        append_bytes(shape, field::dim, one);
    }
    append_number(tensor, field::element_type, static_cast<std::uint64_t>(port.type));
    append_bytes(tensor, field::shape, shape);
    append_bytes(type, field::tensor_type, tensor);
    append_bytes(value, field::value_name,
                 {reinterpret_cast<const std::uint8_t*>(port.name.data()), port.name.size()});
    append_bytes(value, field::value_type, type);
    return value;
}

}  // namespace

ModelFile read_model_file(const std::filesystem::path& path) {
    const auto refuse = [&](const std::string& what) {
        throw Error(ErrorKind::input, path.string() + ": " + what);
    };
    ModelFile model{readers::codec::load_file(path, kLargestModel).bytes, {}, {}};
    Graph graph;
    try {
        for (Message part(model.bytes); part.next();)
            if (part.number == field::graph) read_graph(part.bytes, graph);
    } catch (const NotOnnx&) {
        refuse("it is no ONNX file, or it is cut off; export the network to ONNX");
    }
    std::erase_if(graph.inputs,
                  [&](const ModelPort& port) { return graph.initializers.contains(port.name); });
    if (graph.inputs.empty() || graph.outputs.empty())
        refuse("it is no ONNX file of a network: it has no inputs or no outputs");
    if (std::max(graph.inputs.size(), graph.outputs.size()) > kMostPorts)
        refuse("the network has more than " + std::to_string(kMostPorts) + " inputs or outputs");
    if (graph.has_other_files)
        refuse(
            "the network's weights are in other files; save it as one file (onnx.save without "
            "save_as_external_data)");
    model.inputs = std::move(graph.inputs);
    model.outputs = std::move(graph.outputs);
    return model;
}

std::vector<std::uint8_t> with_shapes(const ModelFile& model, const std::vector<std::vector<int>>& shapes) {
    std::vector<std::uint8_t> file, graph;
    file.reserve(model.bytes.size() + 1024);
    graph.reserve(model.bytes.size() + 1024);
    const auto add = [](std::vector<std::uint8_t>& to, Bytes whole) {
        to.insert(to.end(), whole.begin(), whole.end());
    };
    const auto is_picture = [&](const std::string& name) {
        return std::ranges::any_of(model.inputs, [&](const ModelPort& port) { return port.name == name; });
    };
    for (Message part(model.bytes); part.next();) {
        if (part.number != field::graph) {
            add(file, part.whole);
            continue;
        }
        for (Message inside(part.bytes); inside.next();)
            if (inside.number != field::input || !is_picture(read_port(inside.bytes).name))
                add(graph, inside.whole);
    }
    for (std::size_t i = 0; i < model.inputs.size(); ++i)
        append_bytes(graph, field::input, written(model.inputs[i], shapes.at(i)));
    append_bytes(file, field::graph, graph);
    return file;
}

extern const char* const kModelsYaml;

namespace {

ModelKind kind_of(const YAML::Node& row) {
    ModelKind kind{.name = row["name"].as<std::string>(),
                   .what = row["what"].as<std::string>(),
                   .licence = row["licence"].as<std::string>(""),
                   .sha256 = row["sha256"].as<std::vector<std::string>>(std::vector<std::string>())};
    kind.divisor = row["divisor"].as<double>(kind.divisor);
    kind.mean = row["mean"].as<std::array<double, 3>>(kind.mean);
    kind.std = row["std"].as<std::array<double, 3>>(kind.std);
    kind.multiple = row["multiple"].as<int>(kind.multiple);
    kind.range_px = row["range_px"].as<int>(kind.range_px);
    kind.is_occlusion_visible = row["occlusion"].as<std::string>("hidden") == "visible";
    return kind;
}

// Returns the letters and digits of a name, small.
std::string plain_name(const std::string& name) {
    std::string plain;
    for (const char c : name)
        if (std::isalnum(static_cast<unsigned char>(c)))
            plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

}  // namespace

const std::vector<ModelKind>& model_kinds() {
    static const std::vector<ModelKind> kinds = [] {
        std::vector<ModelKind> rows;
        for (const YAML::Node& row : YAML::Load(kModelsYaml)) rows.push_back(kind_of(row));
        return rows;
    }();
    return kinds;
}

const ModelKind& kind_of_model(const std::filesystem::path& file, const std::string& name) {
    const std::vector<ModelKind>& kinds = model_kinds();
    for (const ModelKind& kind : kinds)
        if (kind.name == name) return kind;
    if (!name.empty())
        throw Error(ErrorKind::usage, "disparity.model_kind must be one of " +
                                          joined(kinds, ", ", &ModelKind::name) + ", not '" + name + "'");
    const std::string sum = files::sha256_of_file(file), plain = plain_name(file.stem().string());
    const ModelKind* best = nullptr;
    for (const ModelKind& kind : kinds) {
        if (std::ranges::find(kind.sha256, sum) != kind.sha256.end()) return kind;
        if (plain.find(kind.name) != std::string::npos && (!best || kind.name.size() > best->name.size()))
            best = &kind;
    }
    return best ? *best : kinds.front();
}

}  // namespace hexrelief::job
