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

// A set of files that appear together or not at all: each is written to a temporary beside its target;
// commit() renames them all; without commit() (an exception, an interrupt) the destructor removes what was
// written, and what killed processes left in a folder goes with the process's first write to it. Symbolic
// links are followed, an existing file keeps its permissions, and what is no regular file (a pipe, a device)
// is written to directly, by commit().
class FileTransaction {
  public:
    // Writes nothing, only counts.
    struct Counting {};
    // Is given each file as it is written: the path, as it was given, and the bytes.
    using Observer = std::function<void(const std::filesystem::path&, const void*, std::size_t)>;
    FileTransaction() = default;
    explicit FileTransaction(Counting) : counting_(true) {}
    explicit FileTransaction(Observer observer) : observer_(std::move(observer)) {}
    FileTransaction(const FileTransaction&) = delete;
    FileTransaction& operator=(const FileTransaction&) = delete;
    ~FileTransaction();
    // What is written to `path` goes to the standard output, by commit().
    void send_to_standard_output(const std::filesystem::path& path) { standard_output_ = path; }
    // Throws Error(output) naming the path and the system's reason.
    void write(const std::filesystem::path& path, const void* data, std::size_t bytes);
    void write(const std::filesystem::path& path, const std::string& text) {
        write(path, text.data(), text.size());
    }
    void write(const std::filesystem::path& path, const std::vector<std::uint8_t>& data) {
        write(path, data.data(), data.size());
    }
    // For a file that is written part by part: the descriptor to write it to until commit(), which stays this
    // object's. Nothing counts or observes the bytes. Throws as write(), and for what is no regular file.
    int open(const std::filesystem::path& path);
    // Puts all files on the disk, then renames them in the order in which they were written. Processes that
    // do so in one folder wait for each other, so that of two sets of the same names one is there whole.
    // Throws Error(output) where a file does not take its bytes or its name; the old files then stay, but for
    // those in file systems without hard links that were replaced before.
    void commit();
    // The paths written so far, as they were given, in order.
    const std::vector<std::filesystem::path>& paths() const { return paths_; }
    // Of all files written so far.
    std::uint64_t bytes() const { return bytes_; }

  private:
    struct Pending {
        std::filesystem::path temporary, target;
        int slot;                        // in the registry that remove_pending_files() empties
        int descriptor;                  // of the temporary; open, it says that its process is alive
        std::filesystem::path old = {};  // while names change: that of the file that was at the target
        bool was_absent = false;         // nothing was at the target
    };
    // What commit() writes to a pipe, a device or the standard output.
    struct Direct {
        std::filesystem::path path, target;  // target: empty = standard output
        std::string bytes;
    };
    bool take_direct(const std::filesystem::path& path, const std::filesystem::path& target, const void* data,
                     std::size_t bytes);
    int prepare(const std::filesystem::path& path, const std::filesystem::path& target);
    void fail_if_stopping(const std::filesystem::path& path) const;
    void open_temporary(const std::filesystem::path& path, const std::filesystem::path& target);
    void write_direct() const;
    // Of the files in this folder.
    std::vector<std::pair<std::filesystem::path, std::filesystem::path>> renames_in(
        const std::filesystem::path& folder) const;
    std::size_t rename_all();
    void undo_renames(std::size_t renamed) noexcept;
    void discard() noexcept;
    std::vector<Pending> pending_;
    std::vector<Direct> direct_;
    std::vector<std::filesystem::path> paths_;
    std::filesystem::path standard_output_;  // empty = none
    Observer observer_;
    std::uint64_t bytes_ = 0;
    bool counting_ = false;
};

// For an interrupted process that is about to exit: removes the temporaries of all live transactions, in all
// threads, and makes every later write() or commit() throw Error(output). A commit() under way in another
// thread ends first, so that a set of files is never left half renamed. Async-signal-safe: may be called from
// a signal handler.
void remove_pending_files() noexcept;

}  // namespace hexrelief::exporters
