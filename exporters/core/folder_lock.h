// Temporary files beside outputs: their names, their removal, and the lock of their folder.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace hexrelief::exporters {

// Returns the name of a temporary file, ".hexrelief-WHAT.tmp".
std::filesystem::path temporary_name(const std::string& what);

// Flushes the folder's entries to the disk, so that its files keep their names through a power cut.
void sync_folder(const std::filesystem::path& folder) noexcept;

// Locks an open file for this process. True if no other process holds it and it still has a name; if the file
// system has no locks, true if it still has a name.
bool claim(int descriptor);

// The lock of a folder: among processes that rename files in a folder at the same time, all but one wait. The
// lock is a file in the folder, which is removed with it. If no such file can be made or locked there is no
// lock: the renames themselves will report what is wrong with the folder.
class FolderLock {
  public:
    // Waits for other processes, until `stopping` is set; for a lock file of another user at most 3 s.
    FolderLock(const std::filesystem::path& folder, const std::atomic<bool>& stopping);
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;
    ~FolderLock();

    // Names in the folder: a complete temporary file, and its new name.
    using Renames = std::vector<std::pair<std::filesystem::path, std::filesystem::path>>;
    // Journals the renames on the disk before they are done. If this process dies while it holds the lock,
    // the next owner of the same user completes them. Does nothing in a folder that others may write to: with
    // a journal of theirs, a later process of this user would rename files as they like.
    void announce(const Renames& renames);
    // Erases the journal of announced renames, which are not to be done.
    void revoke() noexcept;

  private:
    void finish_announced();
    std::filesystem::path path_;
    int descriptor_ = -1;
};

// True if the file is another user's in a sticky folder, where no other user can replace it, but may link it.
bool is_kept_by_owner(const std::filesystem::path& file);

// Marks the only copy of an old file, so that it is no leftover.
void keep_old(const std::filesystem::path& old) noexcept;

// Removes the temporary files that killed processes have left in `folder`. The files of a live process, on
// any machine, are protected by claim().
void remove_leftovers(const std::filesystem::path& folder, const std::atomic<bool>& stopping);

}  // namespace hexrelief::exporters
