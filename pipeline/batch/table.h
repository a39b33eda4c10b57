// The table of a batch, a row per unit with every figure of its report, and its progress messages: a line
// that is rewritten on a terminal, or JSON objects, one per line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/batch/worker.h"

namespace hexrelief::batch {

struct TableRow {
    std::string name, place;
    UnitResult result;
    std::filesystem::path report;  // read if the unit is done or up to date; may be empty
};

// Returns CSV (RFC 4180): the columns name, status, exit_code, error and warnings, then the reports' values
// in their order, named by their keys: "mesh.percent_cost", "stages.mesh.seconds", "outputs.0.bytes". A value
// that a report does not have is an empty cell.
std::string table_csv(const std::vector<TableRow>& rows);

// Returns {"schema": 1, "version": ..., "rows": [{"name", "status", "exit_code", "error", "report": {...}}]};
// error and report are null if there is none. A failed row, which has no report, has "warnings" instead.
std::string table_json(const std::vector<TableRow>& rows);

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
