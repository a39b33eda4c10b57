#include "exporters/inspect/limited.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <new>

#include "pipeline/data/error.h"

namespace hexrelief::inspect {
namespace {

#ifdef __SANITIZE_ADDRESS__
constexpr bool kCanLimitAddresses = false;  // AddressSanitizer reserves terabytes
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool kCanLimitAddresses = false;
#else
constexpr bool kCanLimitAddresses = true;
#endif
#else
constexpr bool kCanLimitAddresses = true;
#endif

constexpr std::uint8_t kDone = 0, kFailed = 1;

void lower(int resource, rlim_t most) {
    rlimit limit{};
    getrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
    limit.rlim_cur = std::min({limit.rlim_cur, limit.rlim_max, most});
    setrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
}

rlim_t addresses_now() {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void write_all(int to, std::uint8_t first, const std::uint8_t* bytes, std::size_t count) {
    if (write(to, &first, 1) != 1) return;
    while (count > 0) {
        const ssize_t written = write(to, bytes, count);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return;
        bytes += written;
        count -= static_cast<std::size_t>(written);
    }
}

void fail(int to, const std::string& reason) {
    write_all(to, kFailed, reinterpret_cast<const std::uint8_t*>(reason.data()), reason.size());
}

// Runs the work and sends its result. Leaves by _exit, so that the caller's unwritten buffers
// are not flushed here.
[[noreturn]] void work_in_child(int to, const WorkLimits& limits, const std::function<WorkBytes()>& work) {
    std::signal(SIGXCPU, SIG_DFL);
    std::signal(SIGSEGV, SIG_DFL);
    lower(RLIMIT_CORE, 0);
    lower(RLIMIT_CPU, limits.seconds);
    if (kCanLimitAddresses) lower(RLIMIT_AS, addresses_now() + limits.memory);
    try {
        const WorkBytes result = work();
        write_all(to, kDone, result.data(), result.size());
    } catch (const Error& error) {
        fail(to, error.what());
    } catch (const std::bad_alloc&) {
        fail(to, "");
    } catch (...) {
        fail(to, "");
    }
    _exit(0);
}

WorkBytes read_all(int from, std::size_t most) {
    WorkBytes bytes;
    std::uint8_t buffer[4096];
    while (bytes.size() <= most) {
        const ssize_t got = read(from, buffer, sizeof buffer);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        bytes.insert(bytes.end(), buffer, buffer + got);
    }
    return bytes;
}

int status_of(pid_t child) {
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

}  // namespace

WorkBytes run_limited(const WorkLimits& limits, const std::string& opening,
                      const std::function<WorkBytes()>& work) {
    int ends[2];
    const auto refuse = [&](const std::string& reason) { throw Error(ErrorKind::input, opening + reason); };
    const char* const no_process =
        "it is decoded in a process of its own, and the system starts none; try later";
    if (pipe2(ends, O_CLOEXEC) != 0) refuse(no_process);
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        work_in_child(ends[1], limits, work);
    }
    close(ends[1]);
    if (child < 0) {
        close(ends[0]);
        refuse(no_process);
    }
    WorkBytes bytes = read_all(ends[0], limits.most_bytes);
    close(ends[0]);
    const int status = status_of(child);
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
        refuse("it takes more than " + std::to_string(limits.seconds) +
               " s of processor time, which no whole file of its length does");
    if (WIFSIGNALED(status)) refuse("its decoder crashes, so it is damaged");
    if (bytes.empty() || (bytes.front() == kFailed && bytes.size() == 1))
        refuse("its decoder wants more memory than files of its length need");
    const std::uint8_t how = bytes.front();
    bytes.erase(bytes.begin());
    if (how == kFailed) throw Error(ErrorKind::input, {bytes.begin(), bytes.end()});
    return bytes;
}

}  // namespace hexrelief::inspect
