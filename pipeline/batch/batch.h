// Runs many units, several at a time; a failed one does not stop the others.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "pipeline/batch/worker.h"

namespace hexrelief::batch {

struct BatchSettings {
    UnitRules rules;  // run_units() sets its threads and jobs
    // Units at a time; 0 = one per thread, or one per device if there are devices.
    int workers = 0;
    int threads = 0;                   // of all workers together; 0 = all that the process may use
    std::uint64_t memory = 0;          // bytes for all workers together; 0 = memory_to_use()
    std::vector<std::string> devices;  // worker i gets device i modulo their number; empty = as found
};

// Callbacks; each may be empty.
struct BatchObserver {
    std::function<void(std::size_t unit, const UnitResult& result)> ended;
    std::function<void()> waits;  // called a few times per second while units are running
};

struct BatchResult {
    std::vector<UnitResult> units;  // in the units' order
    bool interrupted = false;       // by a signal; units that had not ended are marked as failed
};

// Runs the units in their order, as many at a time as workers and memory allow; a single unit may always
// begin. A unit with an error fails with its reason; none stops the others. Call it before any thread is
// started, because workers are forked. Throws std::system_error if not a single worker can be started.
BatchResult run_units(const std::vector<BatchUnit>& units, const BatchSettings& settings,
                      const BatchObserver& observer);

// Sets `wrong` for the units that cannot be run, as far as that is known in advance: because of options,
// places that cannot be written, and files that two units write, or that one writes and another reads.
void check_units(std::vector<BatchUnit>& units, const RequestParser& parse);

}  // namespace hexrelief::batch
