#include "pipeline/batch/manifest.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string_view>

#include "pipeline/batch/manifest_rows.h"
#include "pipeline/config/fields.h"
#include "pipeline/config/options.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBytes = 256 << 20, kMostYamlBytes = 2 << 20;
constexpr std::size_t kLongestLine = 1 << 20;

const std::map<std::string, std::string> kOtherNames = {
    {"colour", "color"}, {"calibration", "calib"}, {"output", "name"}, {"format", "formats"}};

bool holds(const std::vector<std::string>& words, const std::string& word) {
    return std::ranges::find(words, word) != words.end();
}

std::string unknown_key(const std::string& key, const ManifestOptions& options) {
    std::vector<std::string> flags = {"--name", "--formats", "--config"};
    flags.insert(flags.end(), options.file_options.begin(), options.file_options.end());
    for (const config::Field& field : config::config_fields()) flags.push_back(field.option.flag);
    const std::string near = config::nearest_name("--" + key, flags);
    return "unknown key " + readers::codec::excerpt(key) +
           (near.empty() ? "" : " (did you mean '" + near.substr(2) + "'?)") +
           "; keys of the configuration are written as mesh.spacing_px";
}

// Returns the name for a left image: "scene" for both "data/scene_left.png" and "data/scene/left.png".
std::string name_of_file(const fs::path& file) {
    std::string stem = file.stem().string();
    if (stem == "left") return file.parent_path().filename().string();
    for (const char* const ending : {"_left", "-left", ".left"})
        if (stem.ends_with(ending)) stem.erase(stem.size() - std::string_view(ending).size());
    return stem;
}

// Returns the error in a name; empty if there is none. A name may contain folders.
std::string check_name(const fs::path& name) {
    const std::string text = name.string();
    const std::string told = "name " + readers::codec::excerpt(text);
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
    fs::path folder;  // relative names refer to it

    std::string placed(const std::string& file) const { return (folder / file).lexically_normal().string(); }

    // Appends the options that one value stands for. Returns the error; empty if there is none.
    std::string read_value(const std::string& key, const std::string& value, BatchUnit& unit) const {
        auto& words = unit.words;
        const std::string flag = "--" + key;
        const std::vector<const config::Field*> rows = config::rows_of_option(flag);
        if (holds(options.file_options, flag) ||
            (!rows.empty() && rows[0]->type == config::FieldType::file)) {
            words.insert(words.end(), {flag, placed(value)});
        } else if (!rows.empty() && rows[0]->type == config::FieldType::boolean) {
            if (value != "true" && value != "false")
                return key + " must be true or false, not " + readers::codec::excerpt(value);
            if (value == "true") words.push_back(flag);
        } else if (!rows.empty()) {
            words.push_back(flag + "=" + value);  // one word: a value may begin with a dash
        } else if (key == "config") {
            words.insert(words.end(), {"--config", config::find_preset(value) ? value : placed(value)});
        } else if (key.find('.') != std::string::npos) {
            words.insert(words.end(), {"--set", key + "=" + value});
        } else {
            return unknown_key(key, options);
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
        BatchUnit unit{row.place, "", options.words, row.wrong, ErrorKind::usage, row.rule};
        std::vector<std::string> formats = options.formats;
        std::map<std::string, std::string> given;
        for (const auto& [written, value] : row.values) {
            const std::string key = plain_key(written);
            std::string wrong;
            if (!given.try_emplace(key, value).second)
                wrong = "key " + readers::codec::excerpt(key) + " is given twice";
            else if (key == "name")
                unit.name = value;
            else if (key == "formats")
                formats = format_list(value);
            else
                wrong = read_value(key, value, unit);
            if (unit.wrong.empty()) unit.wrong = wrong;
        }
        for (const std::string& flag : options.file_options)
            if (const auto file = given.find(flag.substr(2)); file != given.end() && unit.name.empty())
                unit.name = name_of_file(file->second);
        if (!given.contains("config"))
            for (const std::string& name : options.config)
                unit.words.insert(unit.words.end(), {"--config", name});
        if (unit.wrong.empty()) unit.wrong = check_name(unit.name);
        append_outputs(unit, formats);
        return unit;
    }

    static std::vector<std::string> format_list(const std::string& text) {
        const std::vector<std::string_view> formats = readers::codec::words(text);
        return {formats.begin(), formats.end()};
    }
};

std::string contents_of_manifest(const fs::path& path, std::uintmax_t most) {
    std::error_code code;
    const bool regular = fs::is_regular_file(path, code);  // opening a pipe would block
    std::ifstream file(regular ? path : fs::path(), std::ios::binary);
    if (!file) throw Error(ErrorKind::input, "cannot read the jobs of '" + path.string() + "'");
    if (fs::file_size(path, code) > most)
        throw Error(ErrorKind::input, path.string() + ": larger than " + std::to_string(most >> 20) +
                                          " MiB; this is no manifest");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    std::size_t begin = 0;
    for (std::size_t end = 0; end != std::string::npos; begin = end + 1) {
        end = text.find('\n', begin);
        if (std::min(end, text.size()) - begin > kLongestLine)
            throw Error(ErrorKind::input,
                        path.string() + ": it has a line of more than 1 MiB; this is no manifest");
    }
    return text;
}

std::vector<BatchUnit> option_lines(const std::string& text, const std::string& origin,
                                    const ManifestOptions& options) {
    std::vector<BatchUnit> units;
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        const std::string place = origin + ":" + std::to_string(++number);
        std::vector<std::string> words = config::words_of_line(line);
        if (words.empty() || words.front().starts_with('#')) continue;
        words.insert(words.begin(), options.words.begin(), options.words.end());
        if (!holds(words, "--config"))
            for (const std::string& name : options.config) words.insert(words.end(), {"--config", name});
        units.push_back({place, place, std::move(words), "", ErrorKind::usage});
    }
    return units;
}

// Two names may be one through a link to a folder.
void refuse_equal_names(std::vector<BatchUnit>& units, const fs::path& output) {
    std::map<fs::path, std::string> places;
    for (BatchUnit& unit : units) {
        std::error_code code;
        fs::path target = fs::weakly_canonical(fs::absolute(output) / unit.name, code);
        if (code) target = (output / unit.name).lexically_normal();
        const auto [known, is_new] = places.try_emplace(target, unit.place);
        if (!is_new && unit.wrong.empty())
            unit.wrong = "name " + readers::codec::excerpt(unit.name) + " is that of " + known->second +
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
    if (key.find('.') == std::string::npos) std::ranges::replace(key, '_', '-');
    const auto other = kOtherNames.find(key);
    return other == kOtherNames.end() ? key : other->second;
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
        const std::vector<ManifestRow> rows = is_folder    ? folder_rows(path)
                                              : is_pattern ? pattern_rows(path)
                                                           : rows_of(path, ending);
        for (const ManifestRow& row : rows) units.push_back(reader.read(row));
        refuse_equal_names(units, options.output);
    }
    if (units.empty()) throw Error(ErrorKind::input, path.string() + " holds no job");
    return units;
}

}  // namespace hexrelief::batch
