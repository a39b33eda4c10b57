// The table of known networks, config/models.yaml, which is built into the program.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::job {

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
