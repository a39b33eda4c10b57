// Runs the built program, and gives each test a temporary folder.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::test {

struct ProcessResult {
    int exit_code = -1;  // -signal if a signal ended the process
    std::string out, err;
};

ProcessResult run_program(const std::vector<std::string>& arguments);

// Expects this exit code, a single line on stderr that starts with the program's name and contains `part`,
// and nothing on stdout.
void expect_failure(const std::vector<std::string>& arguments, int exit_code, const std::string& part);

// Returns the exit code of a run whose standard output goes to an existing file.
int run_program_into(const std::string& out, const std::vector<std::string>& arguments);

// Starts the program without waiting; its output is dropped.
pid_t start_program(const std::vector<std::string>& arguments);
int wait_for_exit(pid_t process);

// A temporary folder, removed with its contents at the end.
class TemporaryFolder {
  public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }
    const std::filesystem::path& path() const { return path_; }
    std::size_t entries() const;

  private:
    std::filesystem::path path_;
};

std::string read_text(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, const std::string& text);

// Returns the path of a file of the synthetic pair: left.png, right.png, disparity.pfm, calib.txt.
std::string sample(const std::string& name);

// Returns the arguments for the sample pair, followed by `more`.
std::vector<std::string> pair_arguments(const std::vector<std::string>& more);

}  // namespace hexrelief::test
