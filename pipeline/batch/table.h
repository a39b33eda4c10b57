// The table of a batch: a row per unit, with every figure of its report.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/batch/unit.h"

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

}  // namespace hexrelief::batch
