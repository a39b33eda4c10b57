#include "exporters/core/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

constexpr const char *kPrefix = ".hexrelief-", *kSuffix = ".tmp";

// Where another user's file may not be written, reading it is enough to lock it. O_NONBLOCK: it may be a
// pipe.
int open_to_lock(const fs::path& path, int flags) {
    constexpr int kCommon = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
    const int descriptor = ::open(path.c_str(), O_RDWR | flags | kCommon, 0666);
    return descriptor >= 0 ? descriptor : ::open(path.c_str(), O_RDONLY | kCommon);
}

bool is_open_file(int descriptor, const fs::path& path) {
    struct stat open = {}, named = {};
    return ::fstat(descriptor, &open) == 0 && ::lstat(path.c_str(), &named) == 0 && S_ISREG(open.st_mode) &&
           open.st_ino == named.st_ino && open.st_dev == named.st_dev;
}

std::vector<fs::path> temporaries_in(const fs::path& folder) {
    std::vector<fs::path> found;
    std::error_code code;
    for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
        const std::string name = entry->path().filename().string();
        if (name.starts_with(kPrefix) && name.ends_with(kSuffix)) found.push_back(entry->path());
    }
    return found;
}

}  // namespace

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
    while (!stopping) {
        const int descriptor = open_to_lock(path_, O_CREAT);
        if (descriptor < 0) return;
        int code = 0;
        while ((code = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 ? 0 : errno) == EWOULDBLOCK && !stopping)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (code == 0 && is_open_file(descriptor, path_)) {
            descriptor_ = descriptor;
            return;
        }
        ::close(descriptor);
        if (code != 0) return;
        // Its last holder has removed it meanwhile: another process may hold the new one.
    }
}

FolderLock::~FolderLock() {
    if (descriptor_ < 0) return;
    ::unlink(path_.c_str());
    ::close(descriptor_);
}

void remove_leftovers(const fs::path& folder, const std::atomic<bool>& stopping) {
    if (temporaries_in(folder).empty()) return;
    const FolderLock lock(folder, stopping);  // old files may wait for the end of another process's renames
    const fs::path own = folder / temporary_name("lock");
    for (const fs::path& path : temporaries_in(folder)) {
        if (path == own) continue;
        const int descriptor = open_to_lock(path, 0);
        if (descriptor < 0) continue;
        if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && is_open_file(descriptor, path))
            ::unlink(path.c_str());
        ::close(descriptor);
    }
}

}  // namespace hexrelief
