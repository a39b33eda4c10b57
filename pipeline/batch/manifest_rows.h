// The rows of a manifest as its format gives them: keys and values, before anything is made of them.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace hexrelief::batch {

struct ManifestRow {
    std::string place;                                        // "pairs.csv:3"
    std::vector<std::pair<std::string, std::string>> values;  // by key, in the row's order
    std::string wrong;                                        // why the row cannot be read; empty = it can
};

// A key in the one spelling that those of one meaning have here: "calib" for "calibration", "max-bytes" for
// "max_bytes". Keys of the configuration, which have dots, are as they are.
std::string plain_key(std::string key);

// A header line that names the keys, then a row a line (RFC 4180: quotes, doubled quotes and line ends in
// them). An empty cell gives nothing. Throws Error(usage) where the header is none.
std::vector<ManifestRow> csv_rows(const std::string& text, const std::string& origin);

// An object a line. Nested objects are sections: {"mesh": {"spacing_px": 4}} is mesh.spacing_px. null gives
// nothing.
std::vector<ManifestRow> json_rows(const std::string& text, const std::string& origin);

// A list of mappings, or a mapping of `rows`, that list, and `defaults`, a mapping that each row begins with,
// by plain_key(). Sections and null as in JSON. Throws Error(usage) where the text is neither.
std::vector<ManifestRow> yaml_rows(const std::string& text, const std::string& origin);

// The pairs whose left images' names match the pattern, in the order of their names. "{name}" in it, once,
// stands for any text without a slash, "left" for what is "right" in the right image's name; ending in ".*",
// it takes any image. What stands in place of "left.*" as "calib.txt" is the row's calibration where there is
// such a file. Throws Error: usage for a pattern that is none, input where no pair matches.
std::vector<ManifestRow> pattern_rows(const std::filesystem::path& pattern);

}  // namespace hexrelief::batch
