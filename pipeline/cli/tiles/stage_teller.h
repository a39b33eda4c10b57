// Prints the stages of a command for tiles.
#pragma once

#include <unistd.h>

#include <cstdio>

#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/terminal/progress_line.h"
#include "pipeline/job/log/run_log.h"

namespace hexrelief::cli {

// Prints to stderr: if verbose, a line per stage with its time, else the progress on a terminal; and
// warnings. Prints no progress and no warnings if quiet.
class StageTeller {
  public:
    StageTeller(bool quiet, bool verbose) : progress_(!quiet && !verbose && isatty(STDERR_FILENO)) {
        log_.stage_begins = [this](const std::string& stage) { progress_.begin(stage); };
        log_.stage_progresses = [this](double share) { progress_.update(share); };
        log_.stage_ends = [this, verbose](const std::string& stage, double seconds) {
            progress_.end();
            if (verbose) std::fprintf(stderr, "%-14s %8.3f s\n", stage.c_str(), seconds);
        };
        if (verbose)
            log_.decides = [](const std::string& decision) {
                std::fprintf(stderr, "%s\n", printable(decision).c_str());
            };
        if (!quiet)
            log_.warns = [this](const std::string& warning) {
                progress_.break_line();
                print_warning(warning);
            };
    }
    StageTeller(const StageTeller&) = delete;
    StageTeller& operator=(const StageTeller&) = delete;

    job::RunLog& log() { return log_; }

  private:
    ProgressLine progress_;
    job::RunLog log_;
};

}  // namespace hexrelief::cli
