#include "pipeline/bench/match/match_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "pipeline/data/error.h"

namespace hexrelief::bench::match {
namespace {

constexpr double kFullSizeDiscontinuity_px = 2;

// Returns the file with this stem; empty if the folder has none.
fs::path file_in(const fs::path& folder, const std::string& stem,
                 std::initializer_list<const char*> extensions) {
    for (const char* extension : extensions)
        if (const fs::path path = folder / (stem + extension); fs::is_regular_file(path)) return path;
    return {};
}

fs::path image_in(const fs::path& folder, const std::string& stem) {
    return file_in(folder, stem, {".png", ".ppm", ".pgm", ".jpg"});
}

fs::path map_in(const fs::path& folder, const std::string& stem) {
    return file_in(folder, stem, {".pfm", ".pgm", ".png"});
}

std::optional<double> scale_of(const ScenePair& scene) {
    if (scene.truth.extension() == ".pfm") return 1;
    if (scene.name == "tsukuba") return 16;
    if (scene.truth.parent_path().parent_path().filename() == "middlebury2001") return 8;
    for (const auto& [ending, scale] :
         {std::pair{"-quarter", 4.0}, {"-third", 3.0}, {"-half", 2.0}, {"-full", 1.0}})
        if (scene.name.ends_with(ending)) return scale;
    return std::nullopt;
}

// Adds both pairs of one folder.
void add_pairs(const fs::path& folder, std::vector<ScenePair>& scenes, std::vector<std::string>& left_out) {
    ScenePair scene{folder.filename().string(), "small",
                    image_in(folder, "left"),   image_in(folder, "right"),
                    map_in(folder, "disp"),     map_in(folder, "disp_right")};
    if (scene.left.empty() || scene.right.empty() || scene.truth.empty()) return;
    const auto scale = scale_of(scene);
    if (!scale) {
        left_out.push_back(folder.string() + " (no scale is known for its name)");
        return;
    }
    scene.scale = *scale;
    if (scene.name.ends_with("-half")) scene.size = "half";
    if (scene.name.ends_with("-full")) {
        scene.size = "full";
        scene.discontinuity_px = kFullSizeDiscontinuity_px;
    }
    scenes.push_back(scene);
    scene.left = image_in(folder, "left_color");
    scene.right = image_in(folder, "right_color");
    if (scene.left.empty() || scene.right.empty()) return;
    scene.name += "-color";
    scenes.push_back(scene);
}

// Returns the sum of twelve uniform deviates less 6, with a standard deviation of 1: the
// same on every machine.
double normal_deviate(std::mt19937& random) {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += random() / 4294967296.0;
    return sum - 6;
}

std::uint8_t to_sample(double value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

void add_noise(Image& image, double deviation, unsigned seed) {
    std::mt19937 random(seed);
    for (std::uint8_t& sample : image.pixels) sample = to_sample(sample + deviation * normal_deviate(random));
}

}  // namespace

std::vector<ScenePair> find_scenes(const fs::path& data, std::vector<std::string>& left_out) {
    if (!fs::is_directory(data))
        throw Error(ErrorKind::input,
                    "--data " + data.string() +
                        ": no such folder; give the one that holds middlebury2001/ and so on");
    std::vector<fs::path> folders{data};
    for (const auto& entry : fs::recursive_directory_iterator(data))
        if (entry.is_directory()) folders.push_back(entry.path());
    std::sort(folders.begin(), folders.end());
    std::vector<ScenePair> scenes;
    for (const fs::path& folder : folders) add_pairs(folder, scenes, left_out);
    return scenes;
}

void check_disturbance(const Disturbance& disturbance) {
    if (!(disturbance.noise_percent >= 0 && disturbance.noise_percent <= 100))
        throw Error(ErrorKind::usage, "--noise: must be from 0 to 100 percent");
    for (const auto& [name, value] : {std::pair{"--gamma", disturbance.gamma}, {"--gain", disturbance.gain}})
        if (!(value > 0 && std::isfinite(value)))
            throw Error(ErrorKind::usage, std::string(name) + ": must be above 0");
}

void disturb(StereoPair& pair, const Disturbance& disturbance) {
    check_disturbance(disturbance);
    if (disturbance.gamma != 1 || disturbance.gain != 1) {
        std::array<std::uint8_t, 256> lit{};
        for (int v = 0; v < 256; ++v)
            lit[v] = to_sample(255 * disturbance.gain * std::pow(v / 255.0, disturbance.gamma));
        for (std::uint8_t& sample : pair.right.pixels) sample = lit[sample];
    }
    if (disturbance.noise_percent == 0) return;
    const double deviation = 2.55 * disturbance.noise_percent;
    add_noise(pair.left, deviation, 1);
    add_noise(pair.right, deviation, 2);
}

}  // namespace hexrelief::bench::match
