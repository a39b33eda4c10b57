// Options of the command line for one run.
#pragma once

#include <hexrelief/run.h>

#include <string>
#include <vector>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/commands.h"

namespace hexrelief::cli {

// An option whose value is an input file.
struct FileOption {
    const char *flag, *value, *help;
    std::string FileRequest::*file;
};
const std::vector<FileOption>& file_options();

struct RunOptions {
    FileRequest request;
    config::ConfigOptions config;
    config::KeyOptions keys;
    bool quiet = false, verbose = false;
};

void add_run_options(Command& command, RunOptions& options);

// Returns the library's options that the command line gives, without its files. Throws Error(usage).
Options options_of(const RunOptions& options);

// Calls the library's run() and prints its progress, warnings and results as requested. Throws as run().
void run_and_tell(const RunOptions& options);

}  // namespace hexrelief::cli
