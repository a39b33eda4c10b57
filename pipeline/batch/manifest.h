// Reads the jobs of a batch: each row of a manifest or pair of a folder becomes the command line of a run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/error.h"

namespace hexrelief::batch {

// A row, as the options of `hexrelief run`.
struct BatchUnit {
    std::string place;  // "pairs.csv:3", or the left image of a folder's pair
    std::string name;   // stem of its files in the output folder; for a line of options, its place
    std::vector<std::string> words;
    std::string wrong;                  // why the row cannot be run; empty = it can
    ErrorKind kind = ErrorKind::usage;  // of the error in `wrong`
    std::string rule = {};              // how it was found in a folder; else empty
};

struct ManifestOptions {
    std::filesystem::path output;                // may be empty for lines of options
    std::vector<std::string> formats = {"glb"};  // for rows that name none
    std::vector<std::string> config = {};        // presets and files, for rows that name none
    std::vector<std::string> words = {};         // further options of every row, before its own
    bool depfiles = false;                       // write a make rule beside each row's outputs
    // The options of `hexrelief run` whose value is an input file: "--left". The first of them that a row
    // has names the row.
    std::vector<std::string> file_options = {};
};

// Reads, depending on its name, a manifest (.csv, .jsonl, .ndjson, .yaml, .yml), lines of options of
// `hexrelief run` (.txt and others), the pairs of a folder (file_pattern.h), or those of a pattern with
// "{name}" in it. A row's files are NAME.FORMAT and, as its report, NAME.json in the output folder; file
// names in a manifest are relative to its folder. A row with an error is returned with the reason, and so is
// the second one of two rows of the same name. Throws Error(input) if the manifest cannot be read or holds no
// row, Error(usage) if it is not a manifest.
std::vector<BatchUnit> read_manifest(const std::filesystem::path& path, const ManifestOptions& options);

}  // namespace hexrelief::batch
