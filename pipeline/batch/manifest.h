// What a batch is to do: a manifest or a folder becomes the command line of a run for each row.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/error.h"

namespace hexrelief {

// A row, as the options of `hexrelief run`.
struct BatchUnit {
    std::string place;  // "pairs.csv:3", or the left image of a folder's pair
    std::string name;   // of its files in the output folder; of a line of options, its place
    std::vector<std::string> words;
    std::string wrong;                  // why the row cannot be done; empty = it can
    ErrorKind kind = ErrorKind::usage;  // of what is wrong
};

struct ManifestOptions {
    std::filesystem::path output;                // folder; may be empty for lines of options
    std::vector<std::string> formats = {"glb"};  // of rows that name none
    std::string config = {};                     // preset or file, of rows that name none; may be empty
    std::vector<std::string> words = {};         // further options of every row, before its own
    bool depfiles = false;                       // a rule of make beside each row's outputs
    // Those of `hexrelief run` whose value is a file that is read: "--left". A row is named by the first of
    // them that it has.
    std::vector<std::string> file_options = {};
};

// Reads, by its name, a manifest (.csv, .jsonl, .ndjson, .yaml, .yml), lines of options of `hexrelief run`
// (.txt and others), the pairs of a folder ("{name}_left.*"), or those of a pattern with "{name}" in it. A
// row's files are NAME.FORMAT and, as its report, NAME.json in the output folder; file names in a manifest
// are taken from its folder. A row that is wrong is returned with the reason, and so is the second of two of
// one name. Throws Error: input where the manifest cannot be read or holds no row, usage where it is none.
std::vector<BatchUnit> read_manifest(const std::filesystem::path& path, const ManifestOptions& options);

// The pattern of a folder's pairs.
std::filesystem::path folder_pattern(const std::filesystem::path& folder);

}  // namespace hexrelief
