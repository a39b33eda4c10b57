// The presets of config/, built in, so that `--config quality` needs no file.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::config {

struct Preset {
    std::string name;  // the file's name without ".yaml"
    std::string yaml;
};

const std::vector<Preset>& presets();

// Returns null if no preset has this name.
const Preset* find_preset(const std::string& name);

}  // namespace hexrelief::config
