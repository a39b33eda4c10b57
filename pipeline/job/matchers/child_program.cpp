#include "pipeline/job/matchers/child_program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::job {
namespace {

constexpr std::size_t kLongestLine = 65536;
constexpr std::size_t kKept = 4096;  // of what is printed for people: enough for its last line
constexpr int kNotStarted = 127;     // exit code of shells for this
constexpr int kSlice_ms = 50;        // between two looks at the program, and at the clock
constexpr int kLooksAtClosed = 40;   // at a program that closed its streams and goes on
constexpr int kParts = 32;           // of 4 KiB: more than two pipes hold

using Ends = std::array<int, 2>;

Ends make_pipe() {
    Ends ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
        throw std::system_error(errno, std::generic_category(), "cannot start a program");
    return ends;
}

void close_end(int& end) {
    if (end >= 0) ::close(std::exchange(end, -1));
}

// In the new process: only calls that are safe between fork and exec.
[[noreturn]] void become(char* const* words, int input, int output, int errors, pid_t parent) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(kNotStarted);  // it ended in between
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::signal(SIGPIPE, SIG_DFL);
    ::dup2(input, STDIN_FILENO);
    ::dup2(output, STDOUT_FILENO);
    ::dup2(errors, STDERR_FILENO);
    ::execvp(words[0], words);
    const char* const reason = ::strerror(errno);
    static_cast<void>(!::write(STDERR_FILENO, reason, std::strlen(reason)));
    ::_exit(kNotStarted);
}

}  // namespace

ChildProgram::ChildProgram(std::vector<std::string> words, std::string name)
    : words_(std::move(words)), name_(std::move(name)) {
    std::vector<char*> arguments;
    for (std::string& word : words_) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    Ends input = make_pipe(), output = make_pipe(), errors = make_pipe();
    const pid_t parent = ::getpid();
    process_ = ::fork();
    if (process_ == 0) become(arguments.data(), input[0], output[1], errors[1], parent);
    for (int* const end : {&input[0], &output[1], &errors[1]}) close_end(*end);
    input_ = input[1], output_ = output[0], errors_ = errors[0];
    if (process_ < 0) {
        end();
        throw std::system_error(errno, std::generic_category(), "cannot start a program");
    }
}

ChildProgram::~ChildProgram() {
    end();
}

void ChildProgram::end() {
    for (int* const stream : {&input_, &output_, &errors_}) close_end(*stream);
    if (process_ <= 0) return;
    ::kill(-process_, SIGKILL);
    ::kill(process_, SIGKILL);  // before it has a group of its own
    ::waitpid(process_, &status_, 0);
    process_ = -1;
}

std::string ChildProgram::last_words() const {
    const std::size_t last = complaints_.find_last_not_of(" \t\r\n");
    if (last == std::string::npos) return {};
    const std::size_t before = complaints_.find_last_of("\r\n", last);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    return ": " + readers::codec::excerpt(complaints_.substr(first, last + 1 - first));
}

void ChildProgram::fail(const std::string& what) {
    const std::string told = last_words();
    end();
    throw Error(ErrorKind::input, name_ + " " + what + told);
}

void ChildProgram::fail_by_status() {
    if (WIFSIGNALED(status_)) fail(std::string("was ended: ") + ::strsignal(WTERMSIG(status_)));
    const int code = WEXITSTATUS(status_);
    fail(code == kNotStarted ? "could not be started" : "ended with exit code " + std::to_string(code));
}

bool ChildProgram::has_ended() {
    if (process_ > 0 && ::waitpid(process_, &status_, WNOHANG) == process_) {
        ::kill(-process_, SIGKILL);  // what it started and left behind
        process_ = -1;
    }
    return process_ <= 0;
}

void ChildProgram::take(int& stream, std::string& kept) {
    std::array<char, 4096> part{};
    const ssize_t bytes = ::read(stream, part.data(), part.size());
    if (bytes <= 0)
        close_end(stream);
    else
        kept.append(part.data(), static_cast<std::size_t>(bytes));
}

bool ChildProgram::read_some(int wait_ms) {
    files::wait_if_interrupted();
    std::array<pollfd, 2> streams{pollfd{output_, POLLIN, 0}, pollfd{errors_, POLLIN, 0}};  // -1 is left out
    ::poll(streams.data(), streams.size(), wait_ms);
    if (streams[0].revents != 0) take(output_, printed_);
    if (streams[1].revents != 0) take(errors_, complaints_);
    if (complaints_.size() > 2 * kKept) complaints_.erase(0, complaints_.size() - kKept);
    return output_ >= 0 || errors_ >= 0;
}

void ChildProgram::read_rest() {
    // Not until the streams' end: what the program started may keep them open.
    for (int part = 0; part < kParts && (output_ >= 0 || errors_ >= 0); ++part) read_some(0);
}

void ChildProgram::write_line(const std::string& line) {
    const std::string text = line + "\n";
    for (std::size_t written = 0; written < text.size();) {
        const ssize_t bytes = ::write(input_, text.data() + written, text.size() - written);
        if (bytes < 0 && errno != EINTR) fail("reads no requests");
        if (bytes > 0) written += static_cast<std::size_t>(bytes);
    }
}

std::string ChildProgram::read_line(double timeout_s) {
    const double until = now_seconds() + timeout_s;
    for (int looks_at_closed = 0;;) {
        if (const std::size_t end = printed_.find('\n'); end != std::string::npos) {
            std::string line = printed_.substr(0, end);
            printed_.erase(0, end + 1);
            return line;
        }
        if (printed_.size() > kLongestLine) fail("printed a line of more than 64 KiB in place of an answer");
        const bool is_open = read_some(kSlice_ms);
        const bool ended = has_ended();
        if (ended) read_rest();
        if (printed_.find('\n') != std::string::npos) continue;
        if (ended && status_ != 0) fail_by_status();
        if (ended) fail("ended without an answer");
        // Streams close a moment before a program that ends can be waited for.
        if (!is_open && ++looks_at_closed > kLooksAtClosed) fail("closed its output without an answer");
        if (now_seconds() > until)
            fail("gave no answer within disparity.timeout_s, " + fixed(timeout_s, 0) + " s");
    }
}

void ChildProgram::finish(double timeout_s) {
    close_end(input_);
    const double until = now_seconds() + timeout_s;
    while (!has_ended()) {
        read_some(kSlice_ms);
        printed_.clear();  // for people, who read the error stream's last line
        if (now_seconds() > until)
            fail("did not end within disparity.timeout_s, " + fixed(timeout_s, 0) + " s");
    }
    read_rest();
    if (status_ != 0) fail_by_status();
}

}  // namespace hexrelief::job
