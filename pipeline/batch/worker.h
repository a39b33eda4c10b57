// A process of its own that runs units, one after the other.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/unit.h"

namespace hexrelief::batch {

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

}  // namespace hexrelief::batch
