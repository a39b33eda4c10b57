// Adds --config, --set and the options that set a key to several commands.
#pragma once

#include <hexrelief/hexrelief.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/config/options.h"

namespace hexrelief::cli {

void add_config_options(Command& command, Options& options, const std::string& group);

// Adds the field table's options with these flags; appends those that are given to `options.direct`.
void add_key_options(Command& command, Options& options, const std::vector<std::string>& flags,
                     const std::string& group);

// Selects every N-th item from item K on, for K/N.
struct Shard {
    std::size_t number = 1, of = 1;
};

// Parses "K/N" of --shard; an empty text gives 1/1. Throws Error(usage).
Shard parse_shard(const std::string& text);

// Parses the value of --memory, "8G", "512M", or bytes; an empty text gives 0. Throws Error(usage).
std::uint64_t parse_memory(const std::string& text);

}  // namespace hexrelief::cli
