// All files that a run writes: checked before the work, and undone together where the run fails.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace hexrelief {

// True for "-" with or without an extension, which stands for the standard output.
bool is_standard_output(const std::filesystem::path& path);

// Throws Error(output) where `path` cannot be written: it is a folder, it is write-protected, or its folder
// is so, or cannot be made.
void check_writable_file(const std::filesystem::path& path);
// Throws Error(output) where `folder`, or its nearest parent that exists, is write-protected or no folder.
void check_writable_folder(const std::filesystem::path& folder);

// What tells files apart that exist or not: equal where two names, links among them, are of one file.
struct FileIdentity {
    std::filesystem::path path;          // without links
    std::uint64_t device = 0, node = 0;  // 0 = does not exist

    bool operator==(const FileIdentity& other) const;
};
FileIdentity identify(const std::filesystem::path& path);

// Each file is whole or absent by itself; this makes the set so: without commit(), the files and folders that
// did not exist before are removed again (an overwritten file keeps its new, whole content). One set at a
// time in a process.
class OutputSet {
  public:
    OutputSet() = default;
    OutputSet(const OutputSet&) = delete;
    OutputSet& operator=(const OutputSet&) = delete;
    ~OutputSet();

    // With all missing folders above it.
    void make_folder(const std::filesystem::path& folder);
    // Where the file `path` is to be written: there, in a folder that is made where it is missing; for the
    // standard output, in a temporary file that commit() copies there and removes.
    std::filesystem::path place(const std::filesystem::path& path);
    // Runs `write`, which returns the files it wrote. `planned` are those that it may write.
    std::vector<std::filesystem::path> add(const std::vector<std::filesystem::path>& planned,
                                           const std::function<std::vector<std::filesystem::path>()>& write);
    // Throws Error(output) where the standard output does not take its file; all is then undone.
    void commit();

  private:
    std::filesystem::path for_standard_output_;  // the temporary file; empty = none
};

// For the interrupt's thread: undoes the set at hand and makes every later write fail.
void roll_back_outputs();

}  // namespace hexrelief
