// Parses option values that several commands share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace hexrelief::cli {

// Selects every N-th item from item K on, for K/N.
struct Shard {
    std::size_t number = 1, of = 1;
};

// Parses "K/N" of --shard; an empty text gives 1/1. Throws Error(usage).
Shard parse_shard(const std::string& text);

// Parses the value of --memory, "8G", "512M", or bytes; an empty text gives 0. Throws Error(usage).
std::uint64_t parse_memory(const std::string& text);

}  // namespace hexrelief::cli
