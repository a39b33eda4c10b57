#include "pipeline/batch/manifest.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include "exporters/core/file_names.h"
#include "pipeline/batch/rows.h"
#include "pipeline/batch/shell_words.h"
#include "pipeline/config/presets.h"
#include "pipeline/config/suggest.h"
#include "pipeline/readers/text.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBytes = 256 << 20, kMostYamlBytes = 16 << 20;

// Keys that are options of `hexrelief run`; '_' may stand for '-'.
constexpr std::array<std::string_view, 9> kFileKeys = {"left",  "right", "stereo",     "disparity", "depth",
                                                       "color", "mask",  "confidence", "calib"};
constexpr std::array<std::string_view, 14> kValueKeys = {
    "layout", "depth-unit", "depth-kind", "disparity-scale", "disparity-offset", "unknown", "key",
    "fov-x",  "vertices",   "max-bytes",  "max-error-px",    "backend",          "threads", "seed"};
const std::map<std::string, std::string> kOtherNames = {
    {"colour", "color"}, {"calibration", "calib"}, {"output", "name"}, {"format", "formats"}};

template <typename Keys>
bool holds(const Keys& keys, const std::string& key) {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
}

std::string unknown_key(const std::string& key) {
    std::vector<std::string> names = {"name", "formats", "config", "strict"};
    names.insert(names.end(), kFileKeys.begin(), kFileKeys.end());
    names.insert(names.end(), kValueKeys.begin(), kValueKeys.end());
    const std::string near = nearest_name(key, names);
    return "unknown key " + codec::excerpt(key) + (near.empty() ? "" : " (did you mean '" + near + "'?)") +
           "; keys of the configuration are written as mesh.spacing_px";
}

// "data/scene_left.png" and "data/scene/left.png" are both of "scene".
std::string name_of_file(const fs::path& file) {
    std::string stem = file.stem().string();
    if (stem == "left") return file.parent_path().filename().string();
    for (const char* const ending : {"_left", "-left", ".left"})
        if (stem.ends_with(ending)) stem.erase(stem.size() - std::string_view(ending).size());
    return stem;
}

// Returns what is wrong; empty where all is well. A name may hold folders.
std::string check_name(const fs::path& name) {
    const std::string text = name.string();
    const std::string told = "name " + codec::excerpt(text);
    if (text.empty() || !name.has_filename()) return told + " is none: give the row a 'name'";
    if (name.is_absolute()) return told + " must be relative: it is of a file in the output folder";
    for (const fs::path& part : name)
        if (part == ".." || part == ".") return told + " must stay inside of the output folder";
    for (const char letter : text)
        if (static_cast<unsigned char>(letter) < 0x20) return told + " holds control characters";
    if (name == "batch") return told + " is taken by the batch's table, batch.json; choose another";
    return {};
}

struct RowReader {
    const ManifestOptions& options;
    fs::path folder;  // that relative names are taken from

    std::string placed(const std::string& file) const { return (folder / file).lexically_normal().string(); }

    // Appends the options that one value stands for. Returns what is wrong.
    std::string read_value(const std::string& key, const std::string& value, BatchUnit& unit) const {
        auto& words = unit.words;
        if (holds(kFileKeys, key)) {
            words.insert(words.end(), {"--" + key, placed(value)});
        } else if (holds(kValueKeys, key)) {
            words.push_back("--" + key + "=" + value);  // one word: a value may begin with a dash
        } else if (key == "config") {
            words.insert(words.end(), {"--config", find_preset(value) ? value : placed(value)});
        } else if (key == "strict") {
            if (value != "true" && value != "false")
                return "strict must be true or false, not " + codec::excerpt(value);
            if (value == "true") words.push_back("--strict");
        } else if (key.find('.') != std::string::npos) {
            words.insert(words.end(), {"--set", key + "=" + value});
        } else {
            return unknown_key(key);
        }
        return {};
    }

    void append_outputs(BatchUnit& unit, const std::vector<std::string>& formats) const {
        const std::string stem = (options.output / unit.name).lexically_normal().string();
        std::vector<std::string>& words = unit.words;
        for (const std::string& format : formats) words.insert(words.end(), {"-o", stem + "." + format});
        words.insert(words.end(), {"--report", stem + ".json"});
        if (options.depfiles) words.insert(words.end(), {"--depfile", stem + ".d"});
    }

    BatchUnit read(const ManifestRow& row) const {
        BatchUnit unit{row.place, "", options.words, row.wrong, ErrorKind::usage};
        std::vector<std::string> formats = options.formats;
        std::map<std::string, bool> seen;
        for (const auto& [written, value] : row.values) {
            const std::string key = plain_key(written);
            std::string wrong;
            if (!std::exchange(seen[key], true)) {
                if (key == "name")
                    unit.name = value;
                else if (key == "formats")
                    formats = format_list(value);
                else
                    wrong = read_value(key, value, unit);
                if (unit.name.empty() &&
                    (key == "left" || key == "stereo" || key == "disparity" || key == "depth"))
                    unit.name = name_of_file(value);
            } else {
                wrong = "key " + codec::excerpt(key) + " is given twice";
            }
            if (unit.wrong.empty()) unit.wrong = wrong;
        }
        if (!options.config.empty() && !seen.contains("config"))
            unit.words.insert(unit.words.end(), {"--config", options.config});
        if (unit.wrong.empty()) unit.wrong = check_name(unit.name);
        append_outputs(unit, formats);
        return unit;
    }

    static std::vector<std::string> format_list(const std::string& text) {
        std::vector<std::string> formats;
        for (const std::string_view format : codec::words(text)) formats.emplace_back(format);
        return formats;
    }
};

std::string contents_of_manifest(const fs::path& path, std::uintmax_t most) {
    std::error_code code;
    const bool regular = fs::is_regular_file(path, code);  // opening a pipe would wait
    std::ifstream file(regular ? path : fs::path(), std::ios::binary);
    if (!file) throw Error(ErrorKind::input, "cannot read the jobs of '" + path.string() + "'");
    if (fs::file_size(path, code) > most)
        throw Error(ErrorKind::input, path.string() + ": larger than " + std::to_string(most >> 20) +
                                          " MiB; this is no manifest");
    return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<BatchUnit> option_lines(const std::string& text, const std::string& origin,
                                    const ManifestOptions& options) {
    std::vector<BatchUnit> units;
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        const std::string place = origin + ":" + std::to_string(++number);
        std::vector<std::string> words = words_of_line(line);
        if (words.empty() || words.front().starts_with('#')) continue;
        words.insert(words.begin(), options.words.begin(), options.words.end());
        if (!options.config.empty() && !holds(words, "--config"))
            words.insert(words.begin(), {"--config", options.config});
        units.push_back({place, place, std::move(words), "", ErrorKind::usage});
    }
    return units;
}

void refuse_equal_names(std::vector<BatchUnit>& units) {
    std::map<fs::path, std::string> places;
    for (BatchUnit& unit : units) {
        const auto [known, is_new] = places.try_emplace(fs::path(unit.name).lexically_normal(), unit.place);
        if (!is_new && unit.wrong.empty())
            unit.wrong = "name " + codec::excerpt(unit.name) + " is that of " + known->second +
                         ", too; give each row a 'name' of its own";
    }
}

std::vector<ManifestRow> rows_of(const fs::path& path, const std::string& ending) {
    const std::uintmax_t most = ending == ".yaml" || ending == ".yml" ? kMostYamlBytes : kMostBytes;
    const std::string text = contents_of_manifest(path, most), origin = path.string();
    if (ending == ".csv") return csv_rows(text, origin);
    if (ending == ".jsonl" || ending == ".ndjson") return json_rows(text, origin);
    return yaml_rows(text, origin);
}

bool is_manifest_ending(const std::string& ending) {
    return ending == ".csv" || ending == ".jsonl" || ending == ".ndjson" || ending == ".yaml" ||
           ending == ".yml";
}

}  // namespace

std::string plain_key(std::string key) {
    if (key.find('.') == std::string::npos) std::replace(key.begin(), key.end(), '_', '-');
    const auto other = kOtherNames.find(key);
    return other == kOtherNames.end() ? key : other->second;
}

fs::path folder_pattern(const fs::path& folder) {
    return folder / "{name}_left.*";
}

std::vector<BatchUnit> read_manifest(const fs::path& path, const ManifestOptions& options) {
    std::error_code none;
    const std::string ending = path.extension().string();
    const bool is_folder = fs::is_directory(path, none),
               is_pattern = path.string().find("{name}") != std::string::npos;
    std::vector<BatchUnit> units;
    if (!is_folder && !is_pattern && !is_manifest_ending(ending)) {
        units = option_lines(contents_of_manifest(path, kMostBytes), path.string(), options);
    } else {
        if (options.output.empty())
            throw Error(ErrorKind::usage, "no output: give -o DIR, where each row's files go");
        const bool in_manifest = !is_folder && !is_pattern;
        const RowReader reader{options, in_manifest ? path.parent_path() : fs::path()};
        const std::vector<ManifestRow> rows =
            in_manifest ? rows_of(path, ending) : pattern_rows(is_folder ? folder_pattern(path) : path);
        for (const ManifestRow& row : rows) units.push_back(reader.read(row));
        refuse_equal_names(units);
    }
    if (units.empty()) throw Error(ErrorKind::input, path.string() + " holds no job");
    return units;
}

}  // namespace hexrelief
