// What is fuzzed: each target takes a file's bytes to one of the readers, or a whole run.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace hexrelief::fuzz {

using Bytes = std::span<const std::uint8_t>;

struct Target {
    std::string name;  // and that of its folder of seeds
    void (*run)(Bytes, const std::string& name);
};

// An Error of the kinds that bad input has is what they are to throw; run() lets pass what else is thrown.
const std::vector<Target>& targets();

// Throws std::out_of_range for a name that is none.
const Target& target(const std::string& name);

// Runs it, and ends the process where it throws anything but an Error of one line that input can cause.
void run(const Target& target, Bytes bytes);

// Of a file of that extension in this process's own folder, which holds these bytes until the next call.
std::string file_of(Bytes bytes, const std::string& extension);

// A map of up to 64 x 64 px, a configuration and an output's format out of the bytes.
void run_whole(Bytes bytes, const std::string& name);

}  // namespace hexrelief::fuzz
