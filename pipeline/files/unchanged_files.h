// Detects that another process wrote to a run's inputs while they were read.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

namespace hexrelief::files {

// Remembers the identity, size and modification time of the files with these names. Missing files are left to
// their readers. The clock may be set meanwhile, so times are only compared for equality.
class UnchangedFiles {
  public:
    explicit UnchangedFiles(const std::vector<std::filesystem::path>& paths);
    // Throws Error(input) if one has changed since.
    void check() const;

  private:
    using State = std::array<std::int64_t, 5>;
    static State state_of(const std::filesystem::path& path);
    std::vector<std::pair<std::filesystem::path, State>> files_;
};

}  // namespace hexrelief::files
