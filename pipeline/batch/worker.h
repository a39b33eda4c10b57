// A process of its own that does units, one after the other.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/unit.h"

namespace hexrelief::batch {

// Processes, not threads: a unit that crashes or is killed takes no other with it, and what is global in the
// program, as OpenCV's number of threads, is one unit's alone. A process is forked from one that has started
// nothing, so that it costs a millisecond, and keeps its device from unit to unit.
class Worker {
  public:
    // device: as CUDA_VISIBLE_DEVICES names it; empty = as the environment has it. `others` are the sockets
    // of the workers that there are. Throws std::system_error where the system has no more processes.
    Worker(const std::vector<BatchUnit>& units, const UnitRules& rules, const std::string& device,
           const std::vector<int>& others);
    Worker(Worker&& other) noexcept;
    Worker& operator=(Worker&& other) = delete;
    ~Worker();  // waits for its unit, if any, and its end

    int socket() const { return socket_; }
    bool is_busy() const { return unit_.has_value(); }
    std::size_t unit() const { return *unit_; }
    // False where the process is no more.
    bool start(std::size_t unit);
    // When the socket has something: the result of the unit, or of the process's end, after which nothing
    // more can be started.
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

// The names of the usable devices for the workers, as CUDA_VISIBLE_DEVICES holds them; none without a GPU. A
// process of its own asks, so that nothing has started a device here.
std::vector<std::string> device_names();

// What --gpus asks for: "all" or the first N of them; none for an empty text. Throws Error(device) where
// there is none, Error(usage) for another text.
std::vector<std::string> devices_of(const std::string& text);

}  // namespace hexrelief::batch
