// A folder for files that other programs read and write during a run.
#pragma once

#include <filesystem>

namespace hexrelief::files {

// A folder that only this user may open, in the system's place for temporary files. It is removed with all
// that is in it by the destructor, and if the process is interrupted.
class TemporaryFolder {
  public:
    // Throws Error(output) if no folder can be made.
    TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder();
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

// Removes the folders of this process; called by the interrupt's thread.
void remove_temporary_folders();

}  // namespace hexrelief::files
