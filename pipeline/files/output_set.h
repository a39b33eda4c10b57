// All files that a run writes: checked before the work, and undone together where the run fails.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/file_transaction.h"

namespace hexrelief::files {

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
// Throws Error(usage) where one of the files to be written is one of those that are read. Empty names are
// none.
void check_overwrites(const std::vector<std::filesystem::path>& written,
                      const std::vector<std::filesystem::path>& read);

struct WrittenFile {
    std::filesystem::path path;  // as it was given; "-" = the standard output
    std::uint64_t bytes = 0;
    std::string sha256;
};

// The files of a run, which commit() puts in place together, in the order in which they were written: the
// report last. Without commit() nothing changes: the folders that were made are removed again. Several sets
// may be at work in a process.
class OutputSet {
  public:
    OutputSet();
    OutputSet(const OutputSet&) = delete;
    OutputSet& operator=(const OutputSet&) = delete;

    // With all missing folders above it.
    void make_folder(const std::filesystem::path& folder);
    // To be called before `path` is written to files(): makes its folder where it is missing, or has it go to
    // the standard output.
    void place(const std::filesystem::path& path);
    exporters::FileTransaction& files() { return files_; }
    const std::vector<WrittenFile>& written() const { return written_; }
    // Throws Error(output) as FileTransaction::commit().
    void commit();

  private:
    // The folders that this set needs and that this process has made. Those that no other set needs are
    // removed in the end.
    struct FreshFolders {
        std::vector<std::filesystem::path> paths;
        ~FreshFolders();
    };
    FreshFolders folders_;  // before the files, which leave them first
    exporters::FileTransaction files_;
    std::vector<WrittenFile> written_;
};

// For the interrupt's thread: undoes all sets and makes every later write fail.
void roll_back_outputs();

}  // namespace hexrelief::files
