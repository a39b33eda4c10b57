// All files that a run writes: checked before the work, and undone together if the run fails.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/file_transaction.h"

namespace hexrelief::files {

// True for "-" with or without an extension, which means the standard output.
bool is_standard_output(const std::filesystem::path& path);

// Throws Error(output) if `path` cannot be written: it is a folder or write-protected, or its folder is
// write-protected or cannot be made.
void check_writable_file(const std::filesystem::path& path);
// Throws Error(output) if `folder`, or its nearest existing parent, is write-protected or not a folder.
void check_writable_folder(const std::filesystem::path& folder);

// The identity of a file, which may not exist yet: equal for two names, or links, of the same file.
struct FileIdentity {
    std::filesystem::path path;          // with links resolved
    std::uint64_t device = 0, node = 0;  // 0 = does not exist

    bool operator==(const FileIdentity& other) const;
};
FileIdentity identify(const std::filesystem::path& path);
// Throws Error(usage) if one of the files to be written is one of those that are read.
// Empty names are ignored.
void check_overwrites(const std::vector<std::filesystem::path>& written,
                      const std::vector<std::filesystem::path>& read);

struct WrittenFile {
    std::filesystem::path path;  // as it was given; "-" = the standard output
    std::uint64_t bytes = 0;
    std::string sha256;
};

// The files of a run. commit() puts them in place together, in the order in which they were written, with the
// report last. Without commit() nothing changes, and the folders that were made are removed again. Several
// sets may be in use in a process.
class OutputSet {
  public:
    OutputSet();
    OutputSet(const OutputSet&) = delete;
    OutputSet& operator=(const OutputSet&) = delete;

    // Makes the folder, with all missing folders above it.
    void make_folder(const std::filesystem::path& folder);
    // Prepares the writing of `path` to files(): makes its folder if it is missing, or directs it
    // to the standard output.
    void place(const std::filesystem::path& path);
    // Places and writes a file. Throws Error(output) as FileTransaction::write() does.
    template <typename Bytes>
    void write(const std::filesystem::path& path, const Bytes& bytes) {
        place(path);
        files_.write(path, bytes);
    }
    exporters::FileTransaction& files() { return files_; }
    const std::vector<WrittenFile>& written() const { return written_; }
    // Throws Error(output) as FileTransaction::commit() does.
    void commit();

  private:
    // The folders that this set needs and that this process has made. The destructor removes those that
    // no other set needs.
    struct FreshFolders {
        std::vector<std::filesystem::path> paths;
        ~FreshFolders();
    };
    FreshFolders folders_;  // before the files, so that it is destroyed after them
    exporters::FileTransaction files_;
    std::vector<WrittenFile> written_;
};

// Undoes all sets and makes every later write fail; called by the interrupt's thread.
void roll_back_outputs();

}  // namespace hexrelief::files
