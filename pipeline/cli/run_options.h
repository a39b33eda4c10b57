// Options of the command line for one run.
#pragma once

#include <hexrelief/run.h>

#include <string>
#include <vector>

#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"

namespace hexrelief::cli {

// An option whose value is an input file.
struct FileOption {
    const char *flag, *value;
    std::string help;
    std::string FileRequest::*file;
};
const std::vector<FileOption>& file_options();

// The amount that a run prints: only errors, the summary, or also its decisions and the seconds of its
// stages.
enum class Verbosity { quiet, summary, verbose };

// Adds the options of one run, which set the library's request and options.
void add_run_options(Command& command, FileRequest& files, Options& options, Verbosity& verbosity);

// Returns the options with callbacks that tell stderr of the work: a line for each decision and stage, or its
// progress if stderr is a terminal; and warnings.
Options told_on_terminal(Options options, Verbosity verbosity, ProgressLine& progress);

// Calls the library's run() and prints its progress, warnings and results as requested. Throws as run().
void run_and_tell(const FileRequest& files, const Options& options, Verbosity verbosity);

}  // namespace hexrelief::cli
