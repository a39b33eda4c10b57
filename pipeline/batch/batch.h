// Many units, several at a time, whatever becomes of each.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "pipeline/batch/unit.h"

namespace hexrelief::batch {

struct BatchSettings {
    UnitRules rules;                   // its threads and jobs are set by run_units()
    int workers = 0;                   // units at a time; 0 = one a thread, or with devices one a device
    int threads = 0;                   // of all workers together; 0 = all that the process may use
    std::uint64_t memory = 0;          // bytes for all workers together; 0 = memory_to_use()
    std::vector<std::string> devices;  // worker i is given device i modulo their number; empty = as found
};

struct BatchObserver {
    std::function<void(std::size_t unit, const UnitResult& result)> ended;
    std::function<void()> waits;  // some times a second while units are under way; both may be empty
};

struct BatchResult {
    std::vector<UnitResult> units;  // in the units' order
    bool interrupted = false;       // by a signal; units that had not ended are told as failed
};

// Does the units in their order, as many at a time as there are workers and memory for. One alone may begin
// whatever it takes. A unit that is wrong fails with its reason; none stops the others. Call it before any
// thread is started: workers are forked. Throws std::system_error where not one worker can be started.
BatchResult run_units(const std::vector<BatchUnit>& units, const BatchSettings& settings,
                      const BatchObserver& observer);

// Marks as wrong the units that cannot be done, as far as that is known before the work: options, places that
// cannot be written, and files that two units write, or one writes and another reads.
void check_units(std::vector<BatchUnit>& units, const RequestParser& parse);

}  // namespace hexrelief::batch
