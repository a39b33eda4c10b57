// Finds files by patterns of their names.
#pragma once

#include <filesystem>
#include <map>
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

}  // namespace hexrelief::batch
