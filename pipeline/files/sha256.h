// SHA-256 of files and of data in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace hexrelief::files {

// Returns 64 hexadecimal digits.
std::string sha256_of(const void* data, std::size_t bytes);
// Returns 64 hexadecimal digits. Throws Error(input) if the file cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace hexrelief::files
