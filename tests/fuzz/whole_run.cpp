// A whole run: the bytes are a small map, changes of the configuration, and the format of the output.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"
#include "pipeline/job/runner.h"
#include "tests/fuzz/targets.h"

namespace hexrelief::fuzz {
namespace {

namespace fs = std::filesystem;

// The bytes one after the other; zeros where they have ended.
class Draw {
  public:
    explicit Draw(Bytes bytes) : bytes_(bytes) {}
    unsigned byte() { return at_ < bytes_.size() ? bytes_[at_++] : 0; }
    unsigned word() { return byte() << 8 | byte(); }
    bool is_empty() const { return at_ >= bytes_.size(); }

  private:
    Bytes bytes_;
    std::size_t at_ = 0;
};

// The work grows with these without end, in range or not: what they may be here.
double most_of(const config::Field& field) {
    constexpr std::array<std::pair<const char*, double>, 4> kMost = {
        {{"mesh.t_max", 30}, {"run.threads", 4}, {"mesh.co", 200}, {"mesh.sigma_init", 20}}};
    for (const auto& [path, most] : kMost)
        if (field.path == path) return std::min(most, field.range.max);
    return field.range.max;
}

// A number in range: the ends, and most often small ones.
double number(const config::Field& field, Draw& draw) {
    const double low = field.range.min, high = std::max(low, most_of(field));
    const unsigned how = draw.byte();
    if (how == 0) return low;
    if (how == 1) return high;
    const double share = draw.word() / 65535.0, reach = std::min(high - low, how % 2 == 0 ? 10.0 : 1e6);
    return low + share * reach;
}

void change(config::Config& config, Draw& draw) {
    const auto& fields = config::config_fields();
    const config::Field& field = fields[draw.byte() % fields.size()];
    config::FieldValue value;
    switch (field.type) {
        case config::FieldType::boolean:
            value = draw.byte() % 2 == 1;
            break;
        case config::FieldType::choice:
            value = field.choices[draw.byte() % field.choices.size()];
            break;
        case config::FieldType::integer:
            value = static_cast<long long>(std::floor(number(field, draw)));
            break;
        case config::FieldType::real:
            value = number(field, draw);
            break;
        case config::FieldType::text:
        case config::FieldType::file:
            return;
    }
    field.set(config, value);
}

// As PFM; bytes of 0 are unknown, those of 255 far out of range, and what the bytes do not reach is a
// pattern.
std::vector<std::uint8_t> map_of(Draw& draw) {
    const int width = 1 + static_cast<int>(draw.byte() % 64), height = 1 + static_cast<int>(draw.byte() % 64);
    const float scale = std::array{0.25f, 1.0f, 16.0f, 0.01f}[draw.byte() % 4];
    const std::string head = "Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1\n";
    std::vector<std::uint8_t> file(head.begin(), head.end());
    const unsigned pattern = draw.byte();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const unsigned b =
                draw.is_empty() ? 1 + (pattern + x * 7u / (1 + pattern % 13) + y) % 254 : draw.byte();
            const float value = b == 0 ? INFINITY : b == 255 ? 1e5f : static_cast<float>(b) * scale;
            const auto* const first = reinterpret_cast<const std::uint8_t*>(&value);
            file.insert(file.end(), first, first + sizeof value);
        }
    return file;
}

}  // namespace

void run_whole(Bytes bytes, const std::string&) {
    constexpr std::array kFormats = {".glb", ".gltf", ".drc", ".obj", ".ply", ".stl", ".usdz"};
    Draw draw(bytes);
    job::RunRequest request;
    request.config.run.threads = 1;
    const unsigned changes = draw.byte() % 8;
    const std::string format = kFormats[draw.byte() % kFormats.size()];
    request.config.mesh.spacing_px = 2 + draw.byte() % 6;  // the default is too wide for most of these maps
    for (unsigned i = 0; i < changes; ++i) change(request.config, draw);
    const fs::path map = file_of(map_of(draw), ".pfm");
    request.source = job::DisparityFiles{map};
    const fs::path folder = map.parent_path() / "out";
    fs::create_directories(folder);
    request.outputs = {folder / ("relief" + format)};
    request.report = folder / "report.json";
    try {
        config::check_rules(request.config, "config");
        job::run_job(request);
    } catch (const Error& error) {
        if (std::string(error.what()).find('\n') != std::string::npos) throw;
    }
    fs::remove_all(folder);
}

}  // namespace hexrelief::fuzz
