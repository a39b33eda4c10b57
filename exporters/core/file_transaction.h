// Output files that appear whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief {

// A set of files that appear together or not at all: each is written to a temporary beside its target;
// commit() renames them all; without commit() (an exception, an interrupt) the destructor removes what was
// written. Symbolic links are followed, an existing file keeps its permissions, and what is no regular file
// (a pipe, a device) is written to directly.
class FileTransaction {
  public:
    // Writes nothing, only counts.
    struct Counting {};
    FileTransaction() = default;
    explicit FileTransaction(Counting) : counting_(true) {}
    FileTransaction(const FileTransaction&) = delete;
    FileTransaction& operator=(const FileTransaction&) = delete;
    ~FileTransaction();
    // Throws Error(output) naming the path and the system's reason.
    void write(const std::filesystem::path& path, const void* data, std::size_t bytes);
    void write(const std::filesystem::path& path, const std::string& text) {
        write(path, text.data(), text.size());
    }
    void write(const std::filesystem::path& path, const std::vector<std::uint8_t>& data) {
        write(path, data.data(), data.size());
    }
    // Throws Error(output) where a rename fails; the files renamed before it are removed again.
    void commit();
    // The paths written so far, as they were given, in order.
    const std::vector<std::filesystem::path>& paths() const { return paths_; }
    // Of all files written so far.
    std::uint64_t bytes() const { return bytes_; }

  private:
    struct Pending {
        std::filesystem::path temporary, target;
        int slot;  // in the registry that remove_pending_files() empties
    };
    void discard() noexcept;
    std::vector<Pending> pending_;
    std::vector<std::filesystem::path> paths_;
    std::uint64_t bytes_ = 0;
    bool counting_ = false;
};

// For an interrupted process that is about to exit: removes the temporaries of all live transactions, in all
// threads, and makes every later write() or commit() throw Error(output). A commit() under way in another
// thread ends first, so that a set of files is never left half renamed. Async-signal-safe: may be called from
// a signal handler.
void remove_pending_files() noexcept;

}  // namespace hexrelief
