// A rule for GNU make.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::files {

// The targets depend on all sources. Each source is a target without a recipe as well, so that make goes on
// if one is no longer there. Throws Error(usage) if there is no target, or for a name that make could not
// read back as that name: with control characters, `;`, `$(` or `${`, with `)`, a space or a backslash at its
// end, with a backslash or `%` beside a wildcard, or one of make's special targets.
std::string make_rule(const std::vector<std::filesystem::path>& targets,
                      const std::vector<std::filesystem::path>& sources);

}  // namespace hexrelief::files
