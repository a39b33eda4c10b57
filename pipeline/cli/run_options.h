// One run as a command line asks for it.
#pragma once

#include <hexrelief/run.h>

#include <string>
#include <vector>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/commands.h"

namespace hexrelief::cli {

// An option whose value is a file that is read.
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

// What the options say beside the files. Throws Error(usage).
Options options_of(const RunOptions& options);

// The library's run(), which throws; prints what was asked for.
void run_and_tell(const RunOptions& options);

}  // namespace hexrelief::cli
