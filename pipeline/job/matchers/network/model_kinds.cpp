#include "pipeline/job/matchers/network/model_kinds.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>

#include "pipeline/data/error.h"
#include "pipeline/files/sha256.h"

namespace hexrelief::job {

extern const char* const kModelsYaml;

namespace {

ModelKind kind_of(const YAML::Node& row) {
    ModelKind kind;
    kind.name = row["name"].as<std::string>();
    kind.what = row["what"].as<std::string>();
    kind.licence = row["licence"].as<std::string>("");
    kind.sha256 = row["sha256"].as<std::vector<std::string>>(std::vector<std::string>());
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
    std::string names;
    for (const ModelKind& kind : kinds) {
        if (kind.name == name) return kind;
        names += (names.empty() ? "" : ", ") + kind.name;
    }
    if (!name.empty())
        throw Error(ErrorKind::usage,
                    "disparity.model_kind must be one of " + names + ", not '" + name + "'");
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
