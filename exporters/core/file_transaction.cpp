#include "exporters/core/file_transaction.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

// The registry is an array of atomic pointers and not a locked container, because a signal handler reads it.
// A path belongs to whoever takes it out of its slot by an exchange; the handler never frees it (free() is
// not async-signal-safe).
constexpr int kSlots = 1024;
std::array<std::atomic<char*>, kSlots> registry;
std::atomic<bool> stopping{false};
std::atomic<int> commits_running{0};
std::atomic<unsigned> temporaries_made{0};

constexpr int kNoSlot =
    -1;  // more than kSlots temporaries at once: then only the destructor removes the rest

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

[[noreturn]] void fail(const fs::path& path, int code) {
    throw Error(ErrorKind::output, "cannot write '" + path.string() + "': " + std::strerror(code));
}

[[noreturn]] void fail_interrupted(const fs::path& path) {
    throw Error(ErrorKind::output, "cannot write '" + path.string() + "': interrupted");
}

// Returns 0 or errno; the descriptor is closed in any case.
int write_and_close(int descriptor, const void* data, std::size_t bytes) {
    const char* next = static_cast<const char*>(data);
    int code = 0;
    while (bytes > 0 && code == 0) {
        const ssize_t written = ::write(descriptor, next, bytes);
        if (written >= 0) {
            next += written;
            bytes -= static_cast<std::size_t>(written);
        } else if (errno != EINTR) {
            code = errno;
        }
    }
    if (::close(descriptor) != 0 && code == 0) code = errno;  // network file systems report a full disk here
    return code;
}

// The file that a write to path would end in: links followed, so that a rename replaces the file and not the
// link.
fs::path resolve(const fs::path& path) {
    std::error_code code;
    if (!fs::is_symlink(path, code)) return path;
    fs::path target = fs::weakly_canonical(path, code);
    return code ? path : target;
}

// Signals held off in this thread, so that a handler never runs in the middle of this thread's renames and
// waits for them.
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

}  // namespace

FileTransaction::~FileTransaction() {
    discard();
}

void FileTransaction::discard() noexcept {
    for (const Pending& pending : pending_) {
        ::unlink(pending.temporary.c_str());
        unregister_temporary(pending.slot);
    }
    pending_.clear();
}

void FileTransaction::write(const fs::path& path, const void* data, std::size_t bytes) {
    if (path.empty()) throw Error(ErrorKind::output, "cannot write: the path is empty");
    bytes_ += bytes;
    if (counting_) {
        paths_.push_back(path);
        return;
    }
    const fs::path target = resolve(path);
    struct stat status = {};
    const bool exists = ::stat(target.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode)) fail(path, EISDIR);
    // A rename would replace a write-protected file without a word.
    if (exists && ::faccessat(AT_FDCWD, target.c_str(), W_OK, AT_EACCESS) != 0) fail(path, errno);
    if (exists && !S_ISREG(status.st_mode)) {
        const int descriptor = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor < 0) fail(path, errno);
        if (const int code = write_and_close(descriptor, data, bytes)) fail(path, code);
        paths_.push_back(path);
        return;
    }

    // Not named after the target, whose name may already be as long as the file system allows.
    fs::path temporary = target;
    int descriptor = -1;
    pending_.reserve(pending_.size() + 1);
    do {
        temporary.replace_filename(".hexrelief-" + std::to_string(::getpid()) + "-" +
                                   std::to_string(temporaries_made.fetch_add(1)) + ".tmp");
        const int slot =
            register_temporary(temporary);  // before it exists, lest an interrupt come in between
        if (stopping.load()) {
            unregister_temporary(slot);
            fail_interrupted(path);
        }
        descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor < 0) {
            const int code = errno;
            unregister_temporary(slot);
            if (code != EEXIST) fail(path, code);
        } else {
            pending_.push_back({temporary, target, slot});
        }
    } while (descriptor < 0);
    if (exists) static_cast<void>(::fchmod(descriptor, status.st_mode & 07777));
    if (const int code = write_and_close(descriptor, data, bytes)) fail(path, code);
    if (stopping.load()) {
        ::unlink(temporary.c_str());  // created after remove_pending_files() had gone through the registry
        fail_interrupted(path);
    }
    paths_.push_back(path);
}

void FileTransaction::commit() {
    const SignalsHeld held;
    if (stopping.load()) {
        discard();
        throw Error(ErrorKind::output, "cannot finish writing the output files: interrupted");
    }
    for (std::size_t i = 0; i < pending_.size(); ++i) {
        if (std::rename(pending_[i].temporary.c_str(), pending_[i].target.c_str()) == 0) continue;
        const int code = errno;
        const fs::path failed = pending_[i].target;
        for (std::size_t j = 0; j < i; ++j) ::unlink(pending_[j].target.c_str());
        discard();
        fail(failed, code);
    }
    for (const Pending& pending : pending_) unregister_temporary(pending.slot);
    pending_.clear();
}

void remove_pending_files() noexcept {
    const int saved_errno = errno;
    stopping.store(true);
    while (commits_running.load() > 0) ::sched_yield();
    for (std::atomic<char*>& slot : registry) {
        if (const char* path = slot.exchange(nullptr)) ::unlink(path);
    }
    errno = saved_errno;
}

}  // namespace hexrelief
