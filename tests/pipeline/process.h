// Runs the built program, and gives each test a folder of its own.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::test {

struct ProcessResult {
    int exit_code = -1;  // -signal where the process died of one
    std::string out, err;
};

ProcessResult run_program(const std::vector<std::string>& arguments);

// Expects this exit code, one line on stderr that starts with the program's name and holds `part`, and
// nothing on stdout.
void expect_failure(const std::vector<std::string>& arguments, int exit_code, const std::string& part);

// The exit code with standard output going to a file that exists.
int run_program_into(const std::string& out, const std::vector<std::string>& arguments);

// Starts it without waiting; output is dropped.
pid_t start_program(const std::vector<std::string>& arguments);
int wait_for_exit(pid_t process);

// An empty folder, removed with all it holds at the end.
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

// A file of the synthetic pair: left.png, right.png, disparity.pfm, calib.txt.
std::string sample(const std::string& name);

// Arguments for the sample pair with what is given appended.
std::vector<std::string> pair_arguments(const std::vector<std::string>& more);

}  // namespace hexrelief::test
