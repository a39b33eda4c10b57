// The rules by which the pairs of a folder are found: data alone, from which the search, the command's help,
// its errors and FOLDERS.md are made.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace hexrelief::batch {

// How the files of a unit are named: patterns as in file_pattern.h, from a folder on.
struct PairRule {
    const char* name;
    const char* left;
    const char* right;  // "" if the left file holds both views
    // The calibration is the first of these files that exists. ".*" is the ending of any calibration, and
    // {frame} is {name} without its last "_" and what follows.
    std::vector<const char*> calibrations;
    // True if one view without the other is a mistake, beside other pairs by this rule. Otherwise such a file
    // is none of a pair.
    bool needs_both = true;
    const char* layout = "";  // of a file with both views, if the file does not tell it
    const char* marker = "";  // bytes that are in the first MiB of a file with both views; "" = none

    // Returns "im0.* and im1.*".
    std::string files() const;
};

// Returns the rules in their order: a file belongs to the first rule that finds a unit with it.
std::span<const PairRule> pair_rules();

// The words for left and right in a pattern with {name} that a user gives.
struct SideWords {
    const char *left, *right;
};
std::span<const SideWords> side_words();

}  // namespace hexrelief::batch
