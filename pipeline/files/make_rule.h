// Writes rules for GNU make.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::files {

// Returns a rule by which the targets depend on all sources. Each source is also a target without a recipe,
// so that make goes on if a source no longer exists. Throws Error(usage) if there is no target, or if make
// could not read a name back as that name: with control characters, `;`, `$(` or `${`; with `)`, a space or a
// backslash at its end; with a backslash or `%` beside a wildcard; or equal to a special target of make.
std::string make_rule(const std::vector<std::filesystem::path>& targets,
                      const std::vector<std::filesystem::path>& sources);

}  // namespace hexrelief::files
