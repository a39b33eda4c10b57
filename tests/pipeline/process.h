// Runs the built program, and gives each test a temporary folder.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace hexrelief::test {

struct ProcessResult {
    int exit_code = -1;  // -signal if a signal ended the process
    std::string out, err;
};

ProcessResult run_program(const std::vector<std::string>& arguments,
                          const std::vector<std::string>& more_arguments = {});

// Returns the words of both.
std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more);

// Expects exit code 0. Returns the result.
ProcessResult expect_success(const std::vector<std::string>& arguments,
                             const std::vector<std::string>& more_arguments = {});

// Expects this exit code, a single line on stderr that starts with the program's name and contains `part`,
// and nothing on stdout.
void expect_failure(const std::vector<std::string>& arguments, int exit_code, const std::string& part);

// Returns the exit code of a run whose standard output goes to an existing file.
int run_program_into(const std::string& out, const std::vector<std::string>& arguments);

// Starts the program without waiting; its output is dropped.
pid_t start_program(const std::vector<std::string>& arguments);
int wait_for_exit(pid_t process);

// A temporary folder whose files are named as on a command line.
class TemporaryFolder : public Folder {
  public:
    std::string operator/(const std::string& name) const { return (path() / name).string(); }
};

// Returns the path of a file of the synthetic pair: left.png, right.png, disparity.pfm, calib.txt.
std::string sample(const std::string& name);

// Returns the arguments for the sample pair, followed by `more`.
std::vector<std::string> pair_arguments(const std::vector<std::string>& more);

}  // namespace hexrelief::test
