// Runs units of a batch in worker processes, and estimates the memory that units take, so that only as many
// run as there is room for.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/manifest.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/request.h"

namespace hexrelief::batch {

// Converts the options of `hexrelief run` to a request. Throws Error.
using RequestParser = std::function<job::RunRequest(const std::vector<std::string>& words)>;

enum class UnitOutcome { done, up_to_date, would_run, failed };
std::string outcome_name(UnitOutcome outcome);  // "done", "up_to_date", "would_run", "failed"

struct UnitResult {
    UnitOutcome outcome = UnitOutcome::failed;
    double seconds = 0;
    std::size_t peak_bytes = 0;              // peak memory of the process that ran the unit; 0 = unknown
    int exit_code = 0;                       // the exit code of `hexrelief run`
    std::string message = {};                // one line: why the unit failed, or why it would run; else empty
    std::vector<std::string> warnings = {};  // a line each, of a unit that ran, whether it failed or not
};

struct UnitRules {
    RequestParser parse;
    bool force = false;    // also run units that are up to date
    bool dry_run = false;  // write nothing
    int threads = 1;       // for units that name none
    int jobs = 1;          // number that a process is likely to run: they share a device's start-up
};

// Runs a unit unless it is up to date. A unit without a report is never up to date. Never throws: the
// result holds the failure.
UnitResult do_unit(const BatchUnit& unit, const UnitRules& rules, job::Backends& backends);

// Returns the message and exit code for the current exception. Call it in a catch block.
UnitResult result_of_exception();

// A worker process. Processes are used instead of threads so that a unit that crashes or is killed
// takes no other with it, and global state such as OpenCV's number of threads belongs to one unit. The
// process is forked from one that has started nothing, so it costs a millisecond, and keeps its device
// from unit to unit.
class Worker {
  public:
    // device: a value of CUDA_VISIBLE_DEVICES; empty = as in the environment. `others` are the sockets of the
    // existing workers. Throws std::system_error if the system cannot start another process.
    Worker(const std::vector<BatchUnit>& units, const UnitRules& rules, const std::string& device,
           const std::vector<int>& others);
    Worker(Worker&& other) noexcept;
    Worker& operator=(Worker&& other) = delete;
    ~Worker();  // waits for its unit, if any, and for its end

    int socket() const { return socket_; }
    bool is_busy() const { return unit_.has_value(); }
    std::size_t unit() const { return *unit_; }
    // Starts a unit. False if the process no longer exists.
    bool start(std::size_t unit);
    // To be called when the socket is readable. Returns the result of the unit, or of the process's end,
    // after which nothing more can be started.
    UnitResult finish();
    bool is_dead() const { return dead_; }
    void terminate() const;  // as Ctrl-C does

  private:
    UnitResult result_of_death();
    pid_t process_ = -1;
    int socket_ = -1;
    bool dead_ = false;
    std::optional<std::size_t> unit_;
};

// Returns the usable devices, as values of CUDA_VISIBLE_DEVICES; empty without a GPU. A separate process
// asks, so that no device is started in this one.
std::vector<std::string> device_names();

// Returns the devices that --gpus names: "all", or the first N; none for an empty text. Throws Error(device)
// if there is no usable GPU, Error(usage) for another text.
std::vector<std::string> devices_of(const std::string& text);

// The exit code and the words where memory ends.
inline constexpr int kMemoryExitCode = 6;
inline constexpr const char* kOutOfMemory =
    "out of memory; close other programs, or use smaller pictures or a larger mesh.spacing_px";

// Returns three quarters of the memory that is available now, within the process's control group.
std::uint64_t memory_to_use();

// Corrects estimates by the memory that units took: if one took more than its estimate, those of later units
// are increased by the same factor.
class MemoryRule {
  public:
    explicit MemoryRule(std::uint64_t limit) : limit_(limit) {}
    std::uint64_t expected(std::uint64_t estimate) const;
    // True if another unit may begin beside those whose expected bytes are in use; a single one always may.
    bool fits(std::uint64_t expected, std::uint64_t in_use) const;
    void learn(std::uint64_t estimate, std::uint64_t taken);

  private:
    std::uint64_t limit_;
    double factor_ = 1;
};

}  // namespace hexrelief::batch
