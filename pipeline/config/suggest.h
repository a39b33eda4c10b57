// Finds the nearest of a few names, for "did you mean".
#pragma once

#include <string>
#include <vector>

namespace hexrelief::config {

// Returns the Levenshtein distance, in which a swap of neighbouring letters is one step.
int edit_distance(const std::string& a, const std::string& b);

// Returns the nearest candidate, the first of equals; empty if none is near enough to be meant.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace hexrelief::config
