// SHA-256 of files and of what is written to them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace hexrelief::files {

// 64 hexadecimal digits.
std::string sha256_of(const void* data, std::size_t bytes);
// Throws Error(input) where the file cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace hexrelief::files
