// Detects that another process wrote to a run's inputs while they were read.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

namespace hexrelief::files {

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
