// All files that a run writes: checked before the work, and undone together where the run fails.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace hexrelief {

// Throws Error(output) where `path` cannot be written: its folder is missing or write-protected, or it is a
// folder.
void check_writable_file(const std::filesystem::path& path);
// The same for a folder that is made where it is missing (its nearest existing parent must be writable).
void check_writable_folder(const std::filesystem::path& folder);

// True where both name one file, existing or not.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

// Each file is whole or absent by itself; this makes the set so: without commit(), the files and folders that
// did not exist before are removed again (an overwritten file keeps its new, whole content). One set at a
// time in a process.
class OutputSet {
  public:
    OutputSet() = default;
    OutputSet(const OutputSet&) = delete;
    OutputSet& operator=(const OutputSet&) = delete;
    ~OutputSet();

    void make_folder(const std::filesystem::path& folder);
    // Runs `write`, which returns the files it wrote. `planned` are those that it may write.
    std::vector<std::filesystem::path> add(const std::vector<std::filesystem::path>& planned,
                                           const std::function<std::vector<std::filesystem::path>()>& write);
    void commit();
};

// For the interrupt's thread: undoes the set at hand and makes every later write fail.
void roll_back_outputs();

}  // namespace hexrelief
