#include "pipeline/config/options.h"

#include <algorithm>
#include <cstdio>
#include <iomanip>
#include <map>
#include <sstream>
#include <stdexcept>

#include "pipeline/config/reader.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::config {
namespace {

const Field& given_field(Config& config, const std::string& path) {
    const Field* field = find_field(path);
    if (!field) throw std::logic_error("no field " + path);
    config.given.insert(path);
    return *field;
}

void refuse(const std::string& option, const std::string& wrong) {
    if (!wrong.empty()) throw Error(ErrorKind::usage, option + " " + wrong);
}

std::string group_of(const Field& field) {
    if (field.path.starts_with("input.")) return "Input";
    return field.path.starts_with("export.") ? "Output" : "Job";
}

// Returns the option of the file that a row's option needs; empty = none.
const std::string& file_of(const Field& field) {
    return find_section(section_of(field.path))->file;
}

}  // namespace

Config read_config(const std::vector<std::string>& files, const std::vector<std::string>& settings,
                   const Config& base) {
    Config config = base;
    for (const std::string& file : files)
        if (const Preset* preset = find_preset(file))
            apply_yaml(config, preset->yaml, "preset " + preset->name, {});
        else
            apply_config_file(config, file);
    for (const std::string& setting : settings) apply_setting(config, setting);
    return config;
}

Config budget_base(const BudgetConfig& budget) {
    if (budget.vertices == 0 && budget.max_bytes == 0) return {};
    Config config = read_config({"compact"}, {});
    config.given.clear();
    if (budget.max_bytes == 0) config.exporting = {};  // compression does not change the vertices
    config.decisions = {std::string("budget: the preset compact, because none is named") +
                        (budget.max_bytes == 0
                             ? "; files are written as by default, for only the vertices are limited"
                             : "")};
    return config;
}

void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& text) {
    refuse(option, assign_text(config, given_field(config, path), text));
}

void apply_option(Config& config, const std::string& option, const std::string& path, double value) {
    refuse(option, assign_value(config, given_field(config, path), value));
}

void finish_config(const Config& config) {
    check_rules(config, "");
}

std::vector<std::string> option_flags(const std::string& group) {
    std::vector<std::string> flags;
    for (const Field& field : config_fields()) {
        const std::string& flag = field.option.flag;
        const bool is_known = std::ranges::find(flags, flag) != flags.end();
        if (!flag.empty() && !is_known && group_of(field) == group) flags.push_back(flag);
    }
    return flags;
}

std::vector<const Field*> rows_of_option(const std::string& flag) {
    std::vector<const Field*> rows;
    for (const Field& field : config_fields())
        if (!flag.empty() && field.option.flag == flag) rows.push_back(&field);
    return rows;
}

std::string option_help(const Field& field) {
    return field.help.substr(0, field.help.find(';'));
}

std::string option_value(const Field& field) {
    return field.option.value.empty() ? joined(field.choices, "|") : field.option.value;
}

const Field& row_of_option(const std::string& flag, const std::vector<std::string>& files) {
    const std::vector<const Field*> rows = rows_of_option(flag);
    if (rows.empty()) throw Error(ErrorKind::usage, "'" + flag + "' stands for no key");
    std::string missing;
    for (const Field* row : rows) {
        const std::string& file = file_of(*row);
        if (file.empty() || std::ranges::find(files, file) != files.end()) return *row;
        missing += (missing.empty() ? "" : " or ") + file;
    }
    throw Error(ErrorKind::usage, flag + " goes with " + missing + ", which is not given");
}

std::vector<std::string> keys_of_options(const std::vector<std::pair<std::string, std::string>>& options,
                                         const std::vector<std::string>& files) {
    std::vector<std::string> keys;
    std::map<std::string, int> given;
    for (const auto& [flag, text] : options) {
        const Field& row = row_of_option(flag, files);
        const int times = row.option.second.empty() ? 1 : ++given[flag];
        if (times > 2) throw Error(ErrorKind::usage, flag + " may be given twice, not more often");
        keys.push_back(times == 2 ? row.option.second : row.path);
    }
    return keys;
}

void apply_options(Config& config, const std::vector<std::pair<std::string, std::string>>& options,
                   const std::vector<std::string>& files) {
    const std::vector<std::string> keys = keys_of_options(options, files);
    for (std::size_t i = 0; i < options.size(); ++i)
        apply_option(config, options[i].first, keys[i], options[i].second);
}

std::vector<std::string> words_of_line(const std::string& line) {
    std::istringstream text(line);
    std::vector<std::string> words;
    for (std::string word; text >> std::quoted(word, '"', '\0');) words.push_back(word);
    return words;
}

std::string shell_quoted(const std::string& word) {
    static const std::string kPlain =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./,:@%";
    if (word.find_first_of("\n\r") != std::string::npos)
        throw Error(ErrorKind::usage,
                    readers::codec::excerpt(word) + " holds a line end: no command line can");
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
    // The escapes of bash, zsh and ksh: a terminal would obey control characters (C1's are 2 bytes of UTF-8).
    const auto is_control = [](unsigned char letter) { return letter < 0x20 || letter == 0x7f; };
    if (std::ranges::any_of(word, is_control) || word.find('\xc2') != std::string::npos) {
        std::string escaped = "$'";
        for (const char letter : word) {
            char code[8];
            std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned char>(letter));
            const bool is_ascii = letter >= 0x20 && letter < 0x7f;
            escaped += !is_ascii                          ? code
                       : letter == '\'' || letter == '\\' ? std::string("\\") + letter
                                                          : std::string(1, letter);
        }
        return escaped + "'";
    }
    return "'" + replaced(word, '\'', "'\\''") + "'";
}

std::string shell_line(const std::vector<std::string>& words) {
    return joined(words, " ", shell_quoted);
}

}  // namespace hexrelief::config
