// The batch's table: a row a unit, with every figure of its report.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/batch/unit.h"

namespace hexrelief::batch {

struct TableRow {
    std::string name, place;
    UnitResult result;
    std::filesystem::path report;  // read where the unit is done or up to date; empty = none
};

// RFC 4180. Columns name, status, exit_code and error, then the reports' values in their order there, named
// by their keys: "mesh.percent_cost", "stages.mesh.seconds", "outputs.0.bytes". A value that a report does
// not have is an empty cell.
std::string table_csv(const std::vector<TableRow>& rows);

// {"schema": 1, "version": ..., "rows": [{"name", "status", "exit_code", "error", "report": {...}}]}; error
// and report are null where there is none.
std::string table_json(const std::vector<TableRow>& rows);

}  // namespace hexrelief::batch
