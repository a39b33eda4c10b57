// What a matcher has to know of an ONNX file, and the file with the sizes that it is to be run at.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::job {

// An input or output of the graph.
struct ModelPort {
    std::string name;
    std::vector<long long> dims;  // 0 = not fixed
    int type = 0;                 // the number in ONNX's TensorProto.DataType
};

struct ModelFile {
    std::vector<std::uint8_t> bytes;
    std::vector<ModelPort> inputs, outputs;  // initializers, which older files list as inputs, are left out
};

inline constexpr long long kLargestModel = (1LL << 31) - 1;  // what protocol buffers hold

// Reads the names and shapes; the graph itself is read by whoever runs it. Throws Error(input) if the file is
// missing, larger than kLargestModel or no ONNX file, or keeps its weights in other files.
ModelFile read_model_file(const std::filesystem::path& path);

// Returns the file with these shapes for its inputs, in their order: OpenCV 4.6 runs few graphs whose sizes
// are not fixed.
std::vector<std::uint8_t> with_shapes(const ModelFile& model, const std::vector<std::vector<int>>& shapes);

// How a network wants its pictures, and what it answers; the keys of a row.
struct ModelKind {
    std::string name, what, licence;
    std::vector<std::string> sha256;
    double divisor = 1;
    std::array<double, 3> mean{0, 0, 0}, std{1, 1, 1};  // red, green, blue
    int multiple = 32;
    int range_px = 0;                   // 0 = any
    bool is_occlusion_visible = false;  // true if 1 means visible in its map of occlusions
};

// The first row is the one for files that no other fits.
const std::vector<ModelKind>& model_kinds();

// Returns the row of that name; without a name the row that fits the file, by its SHA-256 or its name.
// Throws Error(usage) if there is no row of that name.
const ModelKind& kind_of_model(const std::filesystem::path& file, const std::string& name);

}  // namespace hexrelief::job
