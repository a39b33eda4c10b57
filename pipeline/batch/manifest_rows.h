// Reads the rows of a manifest as keys and values, independent of the manifest's format.
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
    std::string rule = {};                                    // how it was found in a folder; else empty
};

// Returns the standard spelling of a key: "calib" for "calibration", "max-bytes" for "max_bytes". Keys of the
// configuration, which have dots, are unchanged.
std::string plain_key(std::string key);

// Reads CSV: a header line that names the keys, then one row per line (RFC 4180: quotes, doubled quotes and
// line ends in them). An empty cell gives no value. Throws Error(usage) if there is no valid header.
std::vector<ManifestRow> csv_rows(const std::string& text, const std::string& origin);

// Reads JSON objects, one per line. Nested objects are sections: {"mesh": {"spacing_px": 4}} is
// mesh.spacing_px. null gives no value.
std::vector<ManifestRow> json_rows(const std::string& text, const std::string& origin);

// Reads a YAML list of mappings; or a mapping of `rows`, that list, and `defaults`, a mapping that each row
// begins with, by plain_key(). Sections and null as in JSON. Throws Error(usage) if the text is neither.
std::vector<ManifestRow> yaml_rows(const std::string& text, const std::string& origin);

// Returns the pairs whose left images' names match the pattern, in the order of their names. The pattern
// contains "{name}" once, which stands for any text without a slash, and a word for the left view, such as
// "left" (side_words()), in whose place the right image's name has that for the right one; if it ends in
// ".*", any image matches. The row's calibration is the file with "calib" in place of the word and the ending
// of a calibration, if it exists. Throws Error(usage) for an invalid pattern, Error(input) if no pair
// matches.
std::vector<ManifestRow> pattern_rows(const std::filesystem::path& pattern);

// Returns the pairs in a folder and in the folders below it, up to three levels, by pair_rules(): folder by
// folder, rule by rule, in the order of their names. A row's name is that of the file, or of the folder if
// the rule has no {name}, with the folders between. A view without the other is a row that is wrong, if the
// rule says so. Throws Error(input) if there is none, or a folder cannot be listed.
std::vector<ManifestRow> folder_rows(const std::filesystem::path& folder);

}  // namespace hexrelief::batch
