// SHA-256 of files and of data in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace hexrelief::files {

// Returns 64 hexadecimal digits.
std::string sha256_of(const void* data, std::size_t bytes);
// Returns 64 hexadecimal digits. Throws Error(input) if the file cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

// Remembers the identity, size and times of the files with these names; the time of the last change of
// attributes cannot be set back, as that of the last writing can. Missing files are left to
// their readers. The clock may be set meanwhile, so times are only compared for equality.
class UnchangedFiles {
  public:
    explicit UnchangedFiles(const std::vector<std::filesystem::path>& paths);
    // Throws Error(input) if one has changed since.
    void check() const;

  private:
    using State = std::array<std::int64_t, 7>;
    static State state_of(const std::filesystem::path& path);
    std::vector<std::pair<std::filesystem::path, State>> files_;
};

}  // namespace hexrelief::files
