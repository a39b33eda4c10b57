// "Did you mean": the nearest of a few names.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::config {

// Levenshtein distance with neighbouring letters swapped as one step.
int edit_distance(const std::string& a, const std::string& b);

// The nearest candidate, the first of equals; empty where none is near enough to be meant.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace hexrelief::config
