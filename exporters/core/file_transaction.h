// Output files that appear whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace hexrelief::exporters {

// A set of files that appear together or not at all. Each file is written to a temporary file beside its
// target; commit() renames them all. Without commit() (an exception, an interrupt) the destructor removes
// what was written. The process's first write to a folder also removes the temporary files that killed
// processes have left there. Symbolic links are followed, an existing file keeps its permissions, and targets
// that are not regular files (a pipe, a device) are written to directly, by commit().
class FileTransaction {
  public:
    // Tag for a transaction that writes nothing and only counts bytes.
    struct Counting {};
    // Called for each file as it is written, with the path as it was given, and the bytes.
    using Observer = std::function<void(const std::filesystem::path&, const void*, std::size_t)>;
    FileTransaction() = default;
    explicit FileTransaction(Counting) : counting_(true) {}
    explicit FileTransaction(Observer observer) : observer_(std::move(observer)) {}
    FileTransaction(const FileTransaction&) = delete;
    FileTransaction& operator=(const FileTransaction&) = delete;
    ~FileTransaction();
    // Makes commit() send the file `path` to the standard output.
    void send_to_standard_output(const std::filesystem::path& path) { standard_output_ = path; }
    // Writes a file. Throws Error(output) naming the path and the system's reason.
    void write(const std::filesystem::path& path, const void* data, std::size_t bytes);
    void write(const std::filesystem::path& path, const std::string& text) {
        write(path, text.data(), text.size());
    }
    void write(const std::filesystem::path& path, const std::vector<std::uint8_t>& data) {
        write(path, data.data(), data.size());
    }
    // Opens a file that is to be written part by part. The caller writes to the returned descriptor before
    // commit() by write_opened(); the descriptor remains this object's. Its bytes are neither counted nor
    // observed. Throws what write() throws, and Error(output) if the target is not a regular file.
    int open(const std::filesystem::path& path);
    // Puts all files on the disk, then renames them in the order in which they were written. Processes that
    // do so in the same folder wait for each other, so that one of two sets with the same names is there as a
    // whole. Throws Error(output) if a file cannot take its bytes or its name. The old files then stay,
    // except, in file systems without hard links, those that had been replaced before.
    void commit();
    // Returns the paths written so far, as they were given, in order.
    const std::vector<std::filesystem::path>& paths() const { return paths_; }
    // Returns the bytes of all files written so far.
    std::uint64_t bytes() const { return bytes_; }

  private:
    struct Pending {
        std::filesystem::path temporary, target;
        int slot = -1;  // in the registry that remove_pending_files() empties
        // Descriptor of the temporary file. While it is open, other processes know that this one is alive.
        int descriptor = -1;
        std::filesystem::path old = {};  // during the renames: a hard link to the file that was at the target
        bool was_absent = false;         // there was no file at the target
    };
    // A file that commit() writes to a pipe, a device or the standard output.
    struct Direct {
        std::filesystem::path path, target;  // an empty target is the standard output
        std::string bytes;
    };
    bool take_direct(const std::filesystem::path& path, const std::filesystem::path& target, const void* data,
                     std::size_t bytes);
    int prepare(const std::filesystem::path& path, const std::filesystem::path& target);
    void fail_if_stopping(const std::filesystem::path& path) const;
    void open_temporary(const std::filesystem::path& path, const std::filesystem::path& target);
    void write_direct() const;
    // Returns the renames, temporary to target, of the files in this folder.
    std::vector<std::pair<std::filesystem::path, std::filesystem::path>> renames_in(
        const std::filesystem::path& folder) const;
    std::size_t rename_all();
    // Returns a clause for each old file that could not get its name back.
    std::string undo_renames(std::size_t renamed);
    void discard() noexcept;
    std::vector<Pending> pending_;
    std::vector<Direct> direct_;
    std::vector<std::filesystem::path> paths_;
    std::filesystem::path standard_output_;  // empty = no file goes there
    Observer observer_;
    std::uint64_t bytes_ = 0;
    bool counting_ = false;
};

// Throws Error(output): "cannot write 'PATH': WHAT".
[[noreturn]] void fail_writing(const std::filesystem::path& path, const std::string& what);

// Throws so if a number of bytes or items does not fit into 32 bits; `limit` says that, and what to do.
void check_32_bits(const std::filesystem::path& path, std::size_t count, const char* limit);

// Writes to a descriptor from FileTransaction::open(), at its position. Throws as FileTransaction::write().
void write_opened(int descriptor, const std::filesystem::path& path, const void* data, std::size_t bytes);

// Removes the temporary files of all live transactions, in all threads; for an interrupted process that is
// about to exit. Every later write() or commit() throws Error(output). A commit() under way in another
// thread ends first, so that a set of files is never left half renamed. Async-signal-safe: may be called
// from a signal handler.
void remove_pending_files() noexcept;

}  // namespace hexrelief::exporters
