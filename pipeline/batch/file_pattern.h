// Finds files by patterns of their names, and holds the rules by which the pairs of a folder are found.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hexrelief::batch {

inline constexpr std::string_view kName = "{name}";

// The entries of folders, each folder read once. Names that begin with a dot are left out.
class Listings {
  public:
    // Returns the names in a folder, sorted; none if there is no such folder. Throws Error(input) if it
    // cannot be listed.
    const std::vector<std::string>& of(const std::filesystem::path& folder);

  private:
    std::map<std::filesystem::path, std::vector<std::string>> names_;
};

// {name} next to a letter of the pattern: any text, or one that begins or ends with no letter there, so that
// "{name}L" fits "a_L" and no "wall".
enum class NextToLetters { any, no_letter };

// Returns the files below a folder ("" = the current one) that match a pattern, by the text that stands for
// {name} ("" in a pattern without it). A pattern is a path. {name}, which it has once at most, is any text
// without a slash. ".*" at the end is the ending of any image. Case is ignored in parts with {name} or ".*".
// If images with several endings match, the first ending of the list of images is taken.
std::map<std::string, std::filesystem::path> files_like(const std::filesystem::path& folder,
                                                        const std::string& pattern, NextToLetters next,
                                                        Listings& listings);

// Returns the pattern with `name` in place of {name}.
std::string filled(std::string pattern, std::string_view name);

// A rule by which the pairs of a folder are found: how the files of a unit are named, by patterns as
// files_like() takes them, from a folder on. The rules are data alone, from which the search, the command's
// help, its errors and FOLDERS.md are made.
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
