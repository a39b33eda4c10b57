#include "exporters/core/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <string_view>
#include <thread>

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;

// Renames take milliseconds: who holds a lock for longer only wants others to wait.
constexpr std::chrono::seconds kLongestWaitForOthers{3};

constexpr const char *kPrefix = ".hexrelief-", *kSuffix = ".tmp";

// Opens a lock file. If another user's file may not be written, reading it is enough to lock it. O_NONBLOCK:
// the file may be a pipe.
int open_to_lock(const fs::path& path, int flags) {
    constexpr int kCommon = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
    const int descriptor = ::open(path.c_str(), O_RDWR | flags | kCommon, 0644);
    return descriptor >= 0 ? descriptor : ::open(path.c_str(), O_RDONLY | kCommon);
}

bool is_open_file(int descriptor, const fs::path& path) {
    struct stat open = {}, named = {};
    return ::fstat(descriptor, &open) == 0 && ::lstat(path.c_str(), &named) == 0 && S_ISREG(open.st_mode) &&
           open.st_ino == named.st_ino && open.st_dev == named.st_dev;
}

bool is_of_caller(int descriptor) {
    struct stat status = {};
    return ::fstat(descriptor, &status) == 0 && status.st_uid == ::geteuid();
}

bool is_written_by_caller_alone(const struct stat& status) {
    return status.st_uid == ::geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

// True if only the caller can make files in the folder. Anybody else who can may give the folder a lock file
// with any list of renames, even with an old list of the caller's.
bool is_folder_of_caller_alone(const fs::path& folder) {
    struct stat status = {};
    return ::stat(folder.c_str(), &status) == 0 && is_written_by_caller_alone(status);
}

bool is_kept_old(int descriptor) {
    struct stat status = {};
    return ::fstat(descriptor, &status) == 0 && (status.st_mode & S_ISVTX) != 0;
}

bool is_temporary(const std::string& name) {
    return name.starts_with(kPrefix) && name.ends_with(kSuffix);
}

std::vector<fs::path> temporaries_in(const fs::path& folder) {
    std::vector<fs::path> found;
    std::error_code code;
    for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
        const std::string name = entry->path().filename().string();
        if (is_temporary(name)) found.push_back(entry->path());
    }
    return found;
}

}  // namespace

void sync_folder(const fs::path& folder) noexcept {
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    static_cast<void>(::fsync(descriptor));
    ::close(descriptor);
}

fs::path temporary_name(const std::string& what) {
    return kPrefix + what + kSuffix;
}

bool claim(int descriptor) {
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
    struct stat status = {};
    return ::fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

FolderLock::FolderLock(const fs::path& folder, const std::atomic<bool>& stopping)
    : path_(folder / temporary_name("lock")) {
    const auto patience = std::chrono::steady_clock::now() + kLongestWaitForOthers;
    while (!stopping) {
        const int descriptor = open_to_lock(path_, O_CREAT);
        if (descriptor < 0) return;
        const bool is_own = is_of_caller(descriptor);
        int code = 0;
        while ((code = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 ? 0 : errno) == EWOULDBLOCK && !stopping &&
               (is_own || std::chrono::steady_clock::now() < patience))
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (code == 0 && is_open_file(descriptor, path_)) {
            descriptor_ = descriptor;
            try {
                finish_announced();
            } catch (...) {  // without memory: the next owner completes them
                ::close(descriptor);
                throw;
            }
            return;
        }
        ::close(descriptor);
        if (code != 0) return;
        // Its last holder has removed the file meanwhile: another process may hold the new one.
    }
}

FolderLock::~FolderLock() {
    if (descriptor_ < 0) return;
    ::unlink(path_.c_str());
    ::close(descriptor_);
}

// Each name ends with a zero byte, and the list with an empty name: a list that was not
// written completely is ignored.
void FolderLock::announce(const Renames& renames) {
    if (descriptor_ < 0 || renames.size() < 2) return;            // a single rename needs no journal
    if (!is_folder_of_caller_alone(path_.parent_path())) return;  // the next owner would ignore it
    std::string text;
    for (const auto& [from, to] : renames)
        (text += from.filename().string()).append(1, '\0').append(to.filename().string()).append(1, '\0');
    text += '\0';
    const auto bytes = static_cast<ssize_t>(text.size());
    if (::pwrite(descriptor_, text.data(), text.size(), 0) != bytes || ::fsync(descriptor_) != 0) revoke();
    sync_folder(path_.parent_path());
}

void FolderLock::revoke() noexcept {
    if (descriptor_ >= 0) static_cast<void>(::ftruncate(descriptor_, 0) + ::fsync(descriptor_));
}

// Completes the renames that a killed owner announced. Only a file of this user is trusted: with names that
// another user wrote, this process could be made to replace any file of the folder.
void FolderLock::finish_announced() {
    constexpr off_t longest = 1 << 20;
    struct stat status = {};
    if (::fstat(descriptor_, &status) != 0 || status.st_size < 2 || status.st_size > longest) return;
    const fs::path folder = path_.parent_path();
    if (!is_written_by_caller_alone(status) || status.st_nlink != 1 || !is_folder_of_caller_alone(folder))
        return;
    std::string text(static_cast<std::size_t>(status.st_size), '.');
    if (::pread(descriptor_, text.data(), text.size(), 0) != status.st_size) return;
    if (!text.ends_with(std::string_view("\0\0", 2))) return revoke();
    for (std::size_t at = 0; at + 1 < text.size();) {
        const std::string from = text.c_str() + at, to = text.c_str() + at + from.size() + 1;
        at += from.size() + to.size() + 2;
        const bool are_names =
            is_temporary(from) && !to.empty() && (from + to).find('/') == std::string::npos;
        const fs::path source = folder / from, target = folder / to;
        const int file = are_names ? open_to_lock(source, 0) : -1;
        if (file < 0) continue;  // already renamed
        if (claim(file) && is_open_file(file, source)) ::rename(source.c_str(), target.c_str());
        ::close(file);
    }
    sync_folder(folder);
    revoke();
}

bool is_kept_by_owner(const fs::path& file) {
    struct stat own = {}, folder = {};
    const fs::path parent = file.has_parent_path() ? file.parent_path() : fs::path(".");
    if (::lstat(file.c_str(), &own) != 0 || ::stat(parent.c_str(), &folder) != 0) return false;
    const uid_t user = ::geteuid();
    return (folder.st_mode & S_ISVTX) != 0 && user != 0 && own.st_uid != user && folder.st_uid != user;
}

// The sticky bit means nothing on a regular file.
void keep_old(const fs::path& old) noexcept {
    struct stat status = {};
    if (::stat(old.c_str(), &status) == 0)
        static_cast<void>(::chmod(old.c_str(), (status.st_mode & 07777) | S_ISVTX));
}

void remove_leftovers(const fs::path& folder, const std::atomic<bool>& stopping) {
    if (temporaries_in(folder).empty()) return;
    const FolderLock lock(folder, stopping);  // old files may wait for the end of another process's renames
    const fs::path own = folder / temporary_name("lock");
    for (const fs::path& path : temporaries_in(folder)) {
        if (path == own) continue;
        const int descriptor = open_to_lock(path, 0);
        if (descriptor < 0) continue;
        if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && is_open_file(descriptor, path) &&
            !is_kept_old(descriptor))
            ::unlink(path.c_str());
        ::close(descriptor);
    }
}

}  // namespace hexrelief::exporters
