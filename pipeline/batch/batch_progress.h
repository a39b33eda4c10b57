// The progress messages of a batch: a line that is rewritten on a terminal, or JSON objects, one per line.
#pragma once

#include <cstddef>
#include <string>

#include "pipeline/batch/unit.h"

namespace hexrelief::batch {

// The numbers of units by outcome.
struct BatchCounts {
    std::size_t units = 0;  // in total
    std::size_t done = 0, up_to_date = 0, would_run = 0, failed = 0;

    void add(UnitOutcome outcome);
    std::size_t ended() const { return done + up_to_date + would_run + failed; }
};

// Returns "[####......] 80/200, 2 failed, 12.5 a second, 0:10 left", without a line end.
std::string progress_bar(const BatchCounts& counts, double seconds);

// Returns "200 rows in 16.2 s, 12.3 a second: 190 done, 8 up to date, 2 failed\n".
std::string batch_summary(const BatchCounts& counts, double seconds);

// Each returns one JSON object with its line end. Text that is not UTF-8 becomes U+FFFD.
std::string start_event(const BatchCounts& counts);
std::string unit_event(const BatchUnit& unit, const UnitResult& result, const BatchCounts& counts);
std::string end_event(const BatchCounts& counts, double seconds);

}  // namespace hexrelief::batch
