// The presets of config/, built in: `--config quality` needs no file.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::config {

struct Preset {
    std::string name;  // the file's without ".yaml"
    std::string yaml;
};

const std::vector<Preset>& presets();

// nullptr where there is none.
const Preset* find_preset(const std::string& name);

}  // namespace hexrelief::config
