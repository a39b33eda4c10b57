#include "tests/pipeline/process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

extern char** environ;

namespace hexrelief::test {
namespace {

pid_t spawn(const std::vector<std::string>& arguments, const std::string& out, const std::string& err) {
    std::vector<std::string> words = joined({HEXRELIEF_PROGRAM}, arguments);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    // A shell's background job ignores SIGINT, and what it starts would as well.
    sigset_t heeded;
    sigemptyset(&heeded);
    sigaddset(&heeded, SIGINT);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setsigdefault(&attributes, &heeded);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    pid_t process = 0;
    const int code =
        posix_spawn(&process, HEXRELIEF_PROGRAM, &actions, &attributes, pointers.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (code != 0) throw std::runtime_error("cannot start " HEXRELIEF_PROGRAM);
    return process;
}

}  // namespace

ProcessResult run_program(const std::vector<std::string>& arguments,
                          const std::vector<std::string>& more_arguments) {
    const TemporaryFolder folder;
    const pid_t process = spawn(joined(arguments, more_arguments), folder / "out", folder / "err");
    return {.exit_code = wait_for_exit(process),
            .out = read_text(folder / "out"),
            .err = read_text(folder / "err")};
}

ProcessResult expect_success(const std::vector<std::string>& arguments,
                             const std::vector<std::string>& more_arguments) {
    ProcessResult result = run_program(arguments, more_arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
}

void expect_failure(const std::vector<std::string>& arguments, int exit_code, const std::string& part) {
    const ProcessResult result = run_program(arguments);
    std::string shown;
    for (const std::string& word : arguments) shown += word + " ";
    EXPECT_EQ(result.exit_code, exit_code) << shown << "\n" << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << shown << "\n" << result.err;
    EXPECT_TRUE(result.err.starts_with("hexrelief: ")) << result.err;
    EXPECT_CONTAINS(result.err, part) << shown;
    EXPECT_EQ(result.out, "") << shown;
}

int run_program_into(const std::string& out, const std::vector<std::string>& arguments) {
    return wait_for_exit(spawn(arguments, out, "/dev/null"));
}

pid_t start_program(const std::vector<std::string>& arguments) {
    return spawn(arguments, "/dev/null", "/dev/null");
}

int wait_for_exit(pid_t process) {
    int status = 0;
    if (waitpid(process, &status, 0) != process) return -1000;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

std::string sample(const std::string& name) {
    return std::string(HEXRELIEF_SOURCE_DIR) + "/samples/" + name;
}

std::vector<std::string> pair_arguments(const std::vector<std::string>& more) {
    return joined(
        {"run", "--left", sample("left.png"), "--right", sample("right.png"), "--calib", sample("calib.txt")},
        more);
}

}  // namespace hexrelief::test
