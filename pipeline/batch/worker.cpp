#include "pipeline/batch/worker.h"

#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/job/runner.h"
#include "pipeline/job/stamp/stamp.h"

namespace hexrelief::batch {
namespace {

constexpr std::size_t kLongestText = 16000;

// The head of a packet on the socket, followed by the message and the warnings, which end with a 0 each.
struct ResultHeader {
    UnitOutcome outcome;
    int exit_code;
    double seconds;
    std::size_t peak_bytes;
};

void send_result(int socket, const UnitResult& result) {
    const ResultHeader header{result.outcome, result.exit_code, result.seconds, result.peak_bytes};
    std::string packet(sizeof header, '\0');
    std::memcpy(packet.data(), &header, sizeof header);
    std::string texts = result.message.substr(0, kLongestText - 1) + '\0';
    for (const std::string& warning : result.warnings) texts += warning + '\0';
    packet += texts.substr(0, kLongestText);
    static_cast<void>(::send(socket, packet.data(), packet.size(), MSG_NOSIGNAL));
}

// The worker's process: runs units until the socket is closed.
[[noreturn]] void serve(int socket, const std::vector<BatchUnit>& units, const UnitRules& rules,
                        const std::string& device) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // end with the batch
    // If memory runs out, the system should end a worker rather than the batch.
    std::ofstream("/proc/self/oom_score_adj") << "300";
    if (!device.empty()) ::setenv("CUDA_VISIBLE_DEVICES", device.c_str(), 1);
    files::install_interrupt_handling();
    job::Backends backends;
    std::size_t unit = 0;
    while (::recv(socket, &unit, sizeof unit, 0) == sizeof unit)
        send_result(socket, do_unit(units[unit], rules, backends));
    ::_exit(0);
}

// A lack of memory or processes is told as such by the caller; any other cause is a limit of the system.
[[noreturn]] void fail_to_start() {
    if (errno == EAGAIN || errno == ENOMEM)
        throw std::system_error(EAGAIN, std::generic_category(), "cannot start a worker");
    throw Error(ErrorKind::usage, std::string("cannot start a worker: ") + std::strerror(errno) +
                                      "; raise the limits of this shell (ulimit -n, ulimit -u)");
}

pid_t fork_or_throw() {
    std::fflush(nullptr);  // else buffered output would be written twice
    const pid_t process = ::fork();
    if (process < 0) fail_to_start();
    return process;
}

constexpr int kBug = 1;
constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

// Resets the process's peak memory. On kernels that cannot, it remains the peak so far.
void forget_peak_memory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

// Returns the bytes that a file of the kernel names, in KiB, behind a word; `otherwise` if it does not.
std::uint64_t bytes_in(const char* file, std::string_view name, std::uint64_t otherwise) {
    std::ifstream stream(file);
    for (std::string word; stream >> word;)
        if (word == name) {
            std::uint64_t kib = 0;
            stream >> kib;
            return kib * 1024;
        }
    return otherwise;
}

UnitResult attempt(const BatchUnit& unit, const UnitRules& rules, job::Backends& backends, job::RunLog& log) {
    UnitResult result;
    job::RunRequest request = rules.parse(unit.words);
    if (request.config.run.threads == 0) request.config.run.threads = rules.threads;
    request.jobs = rules.jobs;
    const job::UnitState state = job::stamp_request(request);
    if (!rules.force && state == job::UnitState::current) {
        result.outcome = UnitOutcome::up_to_date;
    } else if (rules.dry_run) {
        result.outcome = UnitOutcome::would_run;
        result.message = state == job::UnitState::missing ? "no result yet"
                         : state == job::UnitState::changed
                             ? "its inputs, configuration, version or outputs changed"
                             : "up to date, but --force is given";
    } else {
        job::run_job(request, backends, log);
        result.outcome = UnitOutcome::done;
    }
    return result;
}

// Returns what the control group may still use; the largest number if it has no limit.
std::uint64_t group_memory() {
    std::uint64_t limit = 0, used = 0;
    std::ifstream("/sys/fs/cgroup/memory.max") >> limit;
    std::ifstream("/sys/fs/cgroup/memory.current") >> used;
    return limit == 0 ? kUnlimited : limit - std::min(limit, used);
}

}  // namespace

Worker::Worker(const std::vector<BatchUnit>& units, const UnitRules& rules, const std::string& device,
               const std::vector<int>& others) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) fail_to_start();
    try {
        process_ = fork_or_throw();
    } catch (...) {
        ::close(ends[0]);
        ::close(ends[1]);
        throw;
    }
    if (process_ == 0) {
        ::close(ends[0]);
        for (const int other : others) ::close(other);  // else it would keep them open when they are to end
        serve(ends[1], units, rules, device);
    }
    ::close(ends[1]);
    socket_ = ends[0];
}

Worker::Worker(Worker&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      socket_(std::exchange(other.socket_, -1)),
      dead_(other.dead_),
      unit_(other.unit_) {}

Worker::~Worker() {
    if (socket_ >= 0) ::close(socket_);
    if (process_ > 0) ::waitpid(process_, nullptr, 0);
}

bool Worker::start(std::size_t unit) {
    if (::send(socket_, &unit, sizeof unit, MSG_NOSIGNAL) != sizeof unit) return false;
    unit_ = unit;
    return true;
}

UnitResult Worker::finish() {
    std::array<char, sizeof(ResultHeader) + kLongestText> packet{};
    const ssize_t bytes = ::recv(socket_, packet.data(), packet.size(), 0);
    unit_.reset();
    if (bytes < static_cast<ssize_t>(sizeof(ResultHeader))) return result_of_death();
    ResultHeader header{};
    std::memcpy(&header, packet.data(), sizeof header);
    UnitResult result{header.outcome, header.seconds, header.peak_bytes, header.exit_code};
    std::istringstream texts(
        std::string(packet.data() + sizeof header, static_cast<std::size_t>(bytes) - sizeof header));
    std::getline(texts, result.message, '\0');
    for (std::string warning; std::getline(texts, warning, '\0');) result.warnings.push_back(warning);
    return result;
}

UnitResult Worker::result_of_death() {
    dead_ = true;
    int status = 0;
    ::waitpid(std::exchange(process_, -1), &status, 0);
    UnitResult result{.exit_code = 1};
    if (WIFSIGNALED(status))
        result.message = std::string("its process was ended: ") + ::strsignal(WTERMSIG(status)) +
                         (WTERMSIG(status) == SIGKILL ? " (by hand, or for want of memory)" : "");
    else
        result.message = "its process ended with exit code " + std::to_string(WEXITSTATUS(status));
    if (WIFEXITED(status) && WEXITSTATUS(status) == files::kInterruptedExitCode) {
        result.exit_code = files::kInterruptedExitCode;
        result.message = "interrupted";
    }
    return result;
}

void Worker::terminate() const {
    if (process_ > 0) ::kill(process_, SIGTERM);
}

std::vector<std::string> device_names() {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    const pid_t process = fork_or_throw();
    if (process == 0) {
        const std::vector<job::DeviceDescription> devices = job::list_devices();
        const auto count = static_cast<unsigned char>(std::ranges::count_if(
            devices,
            [](const job::DeviceDescription& device) { return device.backend == "cuda" && device.usable; }));
        ::_exit(::write(ends[1], &count, 1) == 1 ? 0 : 1);
    }
    ::close(ends[1]);
    unsigned char count = 0;
    if (::read(ends[0], &count, 1) != 1) count = 0;
    ::close(ends[0]);
    ::waitpid(process, nullptr, 0);

    std::vector<std::string> names;
    const char* const visible = std::getenv("CUDA_VISIBLE_DEVICES");
    std::istringstream list(visible ? visible : "");
    for (std::string name; names.size() < count && std::getline(list, name, ',');) names.push_back(name);
    while (names.size() < count) names.push_back(std::to_string(names.size()));
    return names;
}

std::vector<std::string> devices_of(const std::string& text) {
    if (text.empty()) return {};
    const std::vector<std::string> names = device_names();
    if (names.empty()) throw Error(ErrorKind::device, "--gpus: no usable GPU; see 'hexrelief devices'");
    if (text == "all") return names;
    const std::size_t count = whole_number(text).value_or(0);
    if (count < 1 || count > names.size())
        throw Error(ErrorKind::usage, "--gpus: must be 'all' or a number from 1 to " +
                                          std::to_string(names.size()) + ", not '" + text + "'");
    return {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count)};
}

std::string outcome_name(UnitOutcome outcome) {
    constexpr const char* kNames[] = {"done", "up_to_date", "would_run", "failed"};
    return kNames[static_cast<std::size_t>(outcome)];
}

UnitResult result_of_exception() {
    UnitResult result{.outcome = UnitOutcome::failed, .exit_code = kBug};
    try {
        throw;
    } catch (const Error& error) {
        result.exit_code = static_cast<int>(error.kind());
        result.message = error.what();
    } catch (const std::filesystem::filesystem_error& error) {  // a file that vanished or is inaccessible
        result.exit_code = static_cast<int>(ErrorKind::input);
        result.message = "cannot use '" + error.path1().string() + "': " + error.code().message();
    } catch (const std::bad_alloc&) {
        result.exit_code = kMemoryExitCode;
        result.message = kOutOfMemory;
    } catch (const std::system_error& error) {  // thrown by threads, which need memory
        const bool memory = error.code() == std::errc::resource_unavailable_try_again;
        result.exit_code = memory ? kMemoryExitCode : kBug;
        result.message = memory ? kOutOfMemory : std::string("internal error: ") + error.what();
    } catch (const std::exception& error) {
        result.message = std::string("internal error: ") + error.what();
    } catch (...) {
        result.message = "internal error: unknown exception";
    }
    std::ranges::replace(result.message, '\n', ' ');
    return result;
}

UnitResult do_unit(const BatchUnit& unit, const UnitRules& rules, job::Backends& backends) {
    forget_peak_memory();
    const double begun = now_seconds();
    UnitResult result;
    job::RunLog log;
    try {
        result = attempt(unit, rules, backends, log);
    } catch (...) {
        result = result_of_exception();
    }
    result.warnings = log.warnings();
    result.seconds = now_seconds() - begun;
    result.peak_bytes = bytes_in("/proc/self/status", "VmHWM:", 0);
    return result;
}

std::uint64_t memory_to_use() {
    return std::min(bytes_in("/proc/meminfo", "MemAvailable:", kUnlimited), group_memory()) / 4 * 3;
}

std::uint64_t MemoryRule::expected(std::uint64_t estimate) const {
    return static_cast<std::uint64_t>(factor_ * static_cast<double>(estimate));
}

bool MemoryRule::fits(std::uint64_t expected, std::uint64_t in_use) const {
    return in_use == 0 || (in_use < limit_ && expected <= limit_ - in_use);
}

void MemoryRule::learn(std::uint64_t estimate, std::uint64_t taken) {
    factor_ = std::max(factor_, static_cast<double>(taken) / static_cast<double>(estimate));
}

}  // namespace hexrelief::batch
