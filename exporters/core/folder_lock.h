// Temporary files beside outputs: how they are named, who may take them away, and the lock of their folder.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace hexrelief {

// A file beside outputs that is neither named nor kept: ".hexrelief-WHAT.tmp".
std::filesystem::path temporary_name(const std::string& what);

// A folder's names last through a power cut.
void sync_folder(const std::filesystem::path& folder) noexcept;

// True where this process may lock the open file: another one does not hold it, and it still has a name.
// Where the file system knows no locks, it has a name only.
bool claim(int descriptor);

// Among the processes that rename files in a folder at the same time all but one wait. The lock is a file in
// the folder, which goes away with it. Where no such file can be made or locked there is no lock: the renames
// themselves will say what is wrong with the folder.
class FolderLock {
  public:
    // Waits for the others, but not once `stopping` is set.
    FolderLock(const std::filesystem::path& folder, const std::atomic<bool>& stopping);
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;
    ~FolderLock();

    // Names in the folder: of a temporary file that is whole, and what it is to be renamed to.
    using Renames = std::vector<std::pair<std::filesystem::path, std::filesystem::path>>;
    // Puts them on the disk before they are done. If this process is killed before it gives the lock back,
    // the next one of the same user that takes the lock does those that are left. Does nothing in a folder
    // that others may write to: they could have a later process of this user rename what they like.
    void announce(const Renames& renames) noexcept;
    // They are not to be done: announced ones are forgotten.
    void revoke() noexcept;

  private:
    void finish_announced() noexcept;
    std::filesystem::path path_;
    int descriptor_ = -1;
};

// Removes the temporary files in `folder` that a killed process has left there. A process that is alive holds
// its own by claim(), on whatever machine it runs.
void remove_leftovers(const std::filesystem::path& folder, const std::atomic<bool>& stopping);

}  // namespace hexrelief
