#include "exporters/core/file_transaction.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <new>
#include <set>

#include "exporters/core/folder_lock.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;

// The paths of all live temporary files. The registry is an array of atomic pointers and not a locked
// container, because a signal handler reads it. A path belongs to whoever takes it out of its slot by an
// exchange; the handler never frees it (free() is not async-signal-safe).
constexpr int kSlots = 1024;
std::array<std::atomic<char*>, kSlots> registry;
std::atomic<bool> stopping{false};
std::atomic<int> commits_running{0};
std::atomic<unsigned> temporaries_made{0};

// The slot of temporary files beyond kSlots at once: only the destructor removes these.
constexpr int kNoSlot = -1;

int register_temporary(const fs::path& path) {
    char* copy = ::strdup(path.c_str());
    if (!copy) return kNoSlot;
    for (int slot = 0; slot < kSlots; ++slot) {
        char* empty = nullptr;
        if (registry[slot].compare_exchange_strong(empty, copy)) return slot;
    }
    std::free(copy);
    return kNoSlot;
}

void unregister_temporary(int slot) noexcept {
    if (slot != kNoSlot) std::free(registry[slot].exchange(nullptr));
}

[[noreturn]] void fail(const fs::path& path, int code, const std::string& more = {}) {
    fail_writing(path, std::strerror(code) + more);
}

// Writes all bytes. Returns 0 or errno.
int write_to(int descriptor, const void* data, std::size_t bytes) {
    const char* next = static_cast<const char*>(data);
    while (bytes > 0) {
        const ssize_t written = ::write(descriptor, next, bytes);
        if (written >= 0) {
            next += written;
            bytes -= static_cast<std::size_t>(written);
        } else if (errno != EINTR) {
            return errno;
        }
    }
    return 0;
}

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Returns the folders in an order that is the same for all processes, each once whatever its names, so that
// no two processes wait for each other, nor one for itself.
std::vector<fs::path> in_locking_order(const std::vector<fs::path>& folders) {
    std::map<std::pair<dev_t, ino_t>, fs::path> ordered;
    for (const fs::path& folder : folders) {
        struct stat status = {};
        if (::stat(folder.c_str(), &status) == 0) ordered.try_emplace({status.st_dev, status.st_ino}, folder);
    }
    std::vector<fs::path> result;
    for (const auto& [identity, folder] : ordered) result.push_back(folder);
    return result;
}

// Returns the file that a write to `path` would reach: links are followed, so that a rename replaces the file
// and not the link.
fs::path resolve(const fs::path& path) {
    std::error_code code;
    if (!fs::is_symlink(path, code)) return path;
    fs::path target = fs::weakly_canonical(path, code);
    return code ? path : target;
}

// Blocks signals in this thread, so that a handler never interrupts this thread's renames and
// then waits for them.
class SignalsHeld {
  public:
    SignalsHeld() noexcept {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before_);
        commits_running.fetch_add(1);
    }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;
    ~SignalsHeld() {
        commits_running.fetch_sub(1);
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }

  private:
    sigset_t before_;
};

// Removes leftovers once per folder and process: a folder of ten thousand files is not searched again for
// each set of a batch.
void sweep_once(const fs::path& folder) {
    static std::mutex mutex;
    static std::set<fs::path> swept;
    const SignalsHeld held;
    const std::lock_guard lock(mutex);
    std::error_code code;
    if (swept.insert(fs::absolute(folder, code)).second) remove_leftovers(folder, stopping);
}

}  // namespace

FileTransaction::~FileTransaction() {
    discard();
}

void FileTransaction::discard() noexcept {
    for (const Pending& pending : pending_) {
        ::unlink(pending.temporary.c_str());
        ::close(pending.descriptor);
        unregister_temporary(pending.slot);
    }
    pending_.clear();
    direct_.clear();
}

// Returns true if the target is not a file that a rename could replace; its bytes are then kept for commit().
bool FileTransaction::take_direct(const fs::path& path, const fs::path& target, const void* data,
                                  std::size_t bytes) {
    struct stat status = {};
    const bool to_standard_output = !standard_output_.empty() && path == standard_output_;
    if (!to_standard_output && (::stat(target.c_str(), &status) != 0 || S_ISREG(status.st_mode)))
        return false;
    if (S_ISDIR(status.st_mode)) fail(path, EISDIR);
    direct_.push_back({path, to_standard_output ? fs::path() : target, {}});
    if (bytes > 0) direct_.back().bytes.assign(static_cast<const char*>(data), bytes);
    return true;
}

// Opens a temporary file. It is not named after the target, whose name may already be as long as
// the file system allows.
void FileTransaction::open_temporary(const fs::path& path, const fs::path& target) {
    pending_.reserve(pending_.size() + 1);
    for (;;) {
        // All memory is there, and the name registered in case of an interrupt, before the file exists.
        Pending next{folder_of(target) / temporary_name(std::to_string(::getpid()) + "-" +
                                                        std::to_string(temporaries_made.fetch_add(1))),
                     target};
        next.slot = register_temporary(next.temporary);
        if (stopping.load()) {
            unregister_temporary(next.slot);
            fail_writing(path, "interrupted");
        }
        next.descriptor = ::open(next.temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        const int code = errno;
        if (next.descriptor >= 0 && claim(next.descriptor)) {
            pending_.push_back(std::move(next));
            return;
        }
        // Else another process removed it as a leftover before it was claimed.
        if (next.descriptor >= 0) ::close(next.descriptor);
        unregister_temporary(next.slot);
        if (next.descriptor < 0 && code != EEXIST) fail(path, code);
    }
}

// Opens the temporary file of a target and returns its descriptor.
int FileTransaction::prepare(const fs::path& path, const fs::path& target) {
    struct stat status = {};
    const bool exists = ::stat(target.c_str(), &status) == 0;
    // A rename would silently replace a write-protected file.
    if (exists && ::faccessat(AT_FDCWD, target.c_str(), W_OK, AT_EACCESS) != 0) fail(path, errno);
    sweep_once(folder_of(target));
    open_temporary(path, target);
    const int descriptor = pending_.back().descriptor;
    if (exists) static_cast<void>(::fchmod(descriptor, status.st_mode & 07777));
    return descriptor;
}

// Fails if the process is being stopped: the newest temporary file may have been made after
// remove_pending_files() had gone through the registry.
void FileTransaction::fail_if_stopping(const fs::path& path) const {
    if (!stopping.load()) return;
    ::unlink(pending_.back().temporary.c_str());
    fail_writing(path, "interrupted");
}

int FileTransaction::open(const fs::path& path) {
    if (path.empty()) throw Error(ErrorKind::output, "cannot write: the path is empty");
    const fs::path target = resolve(path);
    std::error_code code;
    if (path == standard_output_ || (fs::exists(target, code) && !fs::is_regular_file(target, code)))
        fail_writing(path, "it is no regular file; name one, this file is not written in order");
    const int descriptor = prepare(path, target);
    fail_if_stopping(path);
    paths_.push_back(path);
    return descriptor;
}

void FileTransaction::write(const fs::path& path, const void* data, std::size_t bytes) {
    if (path.empty()) throw Error(ErrorKind::output, "cannot write: the path is empty");
    bytes_ += bytes;
    if (counting_) {
        paths_.push_back(path);
        return;
    }
    const fs::path target = resolve(path);
    if (!take_direct(path, target, data, bytes)) {
        write_opened(prepare(path, target), path, data, bytes);
        fail_if_stopping(path);
    }
    paths_.push_back(path);
    if (observer_) observer_(path, data, bytes);
}

void FileTransaction::write_direct() const {
    for (const Direct& direct : direct_) {
        if (direct.target.empty()) {
            int code = std::fflush(stdout) == 0 ? 0 : errno;
            if (code == 0) code = write_to(STDOUT_FILENO, direct.bytes.data(), direct.bytes.size());
            if (code != 0) fail("-", code);
            continue;
        }
        const int descriptor = ::open(direct.target.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor < 0) fail(direct.path, errno);
        int code = write_to(descriptor, direct.bytes.data(), direct.bytes.size());
        if (::close(descriptor) != 0 && code == 0) code = errno;
        if (code != 0) fail(direct.path, code);
    }
}

std::vector<std::pair<fs::path, fs::path>> FileTransaction::renames_in(const fs::path& folder) const {
    std::vector<std::pair<fs::path, fs::path>> renames;
    std::error_code code;
    for (const Pending& pending : pending_)
        if (fs::equivalent(folder_of(pending.target), folder, code))
            renames.emplace_back(pending.temporary, pending.target);
    return renames;
}

// Renames the files. Returns how many were renamed; errno is set if these are not all.
std::size_t FileTransaction::rename_all() {
    std::size_t renamed = 0;
    try {
        for (; renamed < pending_.size(); ++renamed) {
            Pending& pending = pending_[renamed];
            fs::path old = pending.temporary;
            old.replace_extension(".old.tmp");
            if (is_kept_by_owner(pending.target)) {
                errno = EPERM;
                break;
            }
            if (::link(pending.target.c_str(), old.c_str()) == 0)
                pending.old = std::move(old);
            else
                pending.was_absent = errno == ENOENT;
            if (std::rename(pending.temporary.c_str(), pending.target.c_str()) != 0) break;
        }
    } catch (const std::bad_alloc&) {
        errno = ENOMEM;
    }
    return renamed;
}

std::string FileTransaction::undo_renames(std::size_t renamed) {
    std::string kept;
    for (std::size_t i = std::min(renamed + 1, pending_.size()); i-- > 0;) {
        const Pending& pending = pending_[i];
        if (!pending.old.empty() && i < renamed) {
            if (std::rename(pending.old.c_str(), pending.target.c_str()) == 0) continue;
            std::error_code code;
            if (fs::copy_file(pending.old, pending.target, fs::copy_options::overwrite_existing, code)) {
                ::unlink(pending.old.c_str());
                continue;
            }
            keep_old(pending.old);
            kept += "; the old file is kept as " + pending.old.string();
        } else if (!pending.old.empty()) {
            ::unlink(pending.old.c_str());
        } else if (pending.was_absent && i < renamed) {
            ::unlink(pending.target.c_str());
        }
    }
    return kept;
}

void FileTransaction::commit() {
    for (const Pending& pending : pending_)
        if (::fsync(pending.descriptor) != 0 && errno != EINVAL && errno != EROFS)
            fail(pending.target, errno);
    write_direct();  // before any rename, since it may wait for a pipe's reader, and may fail
    direct_.clear();
    std::vector<fs::path> folders;
    for (const Pending& pending : pending_) folders.push_back(folder_of(pending.target));
    folders = in_locking_order(folders);
    {
        const SignalsHeld held;
        std::list<FolderLock> locks;
        for (const fs::path& folder : folders) locks.emplace_back(folder, stopping);
        if (stopping.load()) {
            discard();
            throw Error(ErrorKind::output, "cannot finish writing the output files: interrupted");
        }
        auto folder = folders.begin();
        for (FolderLock& lock : locks) lock.announce(renames_in(*folder++));
        if (const std::size_t renamed = rename_all(); renamed < pending_.size()) {
            const int code = errno;
            for (FolderLock& lock : locks) lock.revoke();
            const std::string kept = undo_renames(renamed);
            const fs::path failed = std::move(pending_[renamed].target);
            discard();
            fail(failed, code, kept);
        }
        for (const Pending& pending : pending_)
            if (!pending.old.empty()) ::unlink(pending.old.c_str());
    }
    for (const Pending& pending : pending_) {
        ::close(pending.descriptor);
        unregister_temporary(pending.slot);
    }
    pending_.clear();
    for (const fs::path& folder : folders) sync_folder(folder);
}

void fail_writing(const fs::path& path, const std::string& what) {
    throw Error(ErrorKind::output, "cannot write '" + path.string() + "': " + what);
}

void check_32_bits(const fs::path& path, std::size_t count, const char* limit) {
    if (count > std::numeric_limits<std::uint32_t>::max()) fail_writing(path, limit);
}

void write_opened(int descriptor, const fs::path& path, const void* data, std::size_t bytes) {
    if (const int code = write_to(descriptor, data, bytes)) fail(path, code);
}

void remove_pending_files() noexcept {
    const int saved_errno = errno;
    stopping.store(true);
    while (commits_running.load() > 0) ::sched_yield();
    for (std::atomic<char*>& slot : registry)
        if (const char* path = slot.exchange(nullptr)) ::unlink(path);
    errno = saved_errno;
}

}  // namespace hexrelief::exporters
