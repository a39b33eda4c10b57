// SHA-256 of files.
#pragma once

#include <filesystem>
#include <string>

namespace hexrelief {

// 64 hexadecimal digits. Throws Error(input) where the file cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace hexrelief
