// Values of options that several commands take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace hexrelief::cli {

// K/N: every N-th item from item K on.
struct Shard {
    std::size_t number = 1, of = 1;
};

// "K/N" of --shard; 1/1 for an empty text. Throws Error(usage).
Shard parse_shard(const std::string& text);

// Of --memory: "8G", "512M", or bytes; 0 for an empty text. Throws Error(usage).
std::uint64_t parse_memory(const std::string& text);

}  // namespace hexrelief::cli
