#include "pipeline/cli/piped_inputs.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "pipeline/data/error.h"

namespace hexrelief::cli {
namespace {

constexpr std::uintmax_t kMost = std::uintmax_t{4} << 30;

// True for a pipe that this process was given open, as shells give it.
bool is_open_pipe(const std::filesystem::path& path) {
    std::error_code code;
    if (!std::filesystem::is_fifo(path, code)) return false;
    return std::filesystem::canonical(path.parent_path(), code).string().starts_with("/proc/");
}

std::string name_of(const std::string& given) {
    return given == "-" ? "the standard input" : "'" + given + "'";
}

[[noreturn]] void refuse(const std::string& given, const std::string& what) {
    throw Error(ErrorKind::input, "cannot read " + name_of(given) + ": " + what);
}

void copy(int from, int to, const std::string& given) {
    std::vector<char> buffer(1 << 20);
    std::uintmax_t copied = 0;
    for (;;) {
        const ssize_t count = read(from, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) refuse(given, std::strerror(errno));
        if (count == 0) return;
        copied += static_cast<std::uintmax_t>(count);
        if (copied > kMost) refuse(given, "it holds more than 4 GiB; copy it to a file first");
        for (ssize_t written = 0; written < count;) {
            const ssize_t more =
                write(to, buffer.data() + written, static_cast<std::size_t>(count - written));
            if (more < 0 && errno == EINTR) continue;
            if (more <= 0)
                refuse(given, std::string("no copy of it in the temporary folder: ") + std::strerror(errno));
            written += more;
        }
    }
}

}  // namespace

PipedInputs::~PipedInputs() {
    for (const Copy& copy : copies_) close(copy.file);
}

std::string PipedInputs::file_of(const std::string& path) {
    const bool is_standard_input = path == "-" || path == "/dev/stdin";
    if (!is_standard_input && !is_open_pipe(path)) return path;
    if (std::ranges::any_of(copies_, [&](const Copy& copy) { return copy.given == path; }))
        throw Error(ErrorKind::usage, name_of(path) + " is given twice; it can be read once");
    if (is_standard_input && isatty(STDIN_FILENO))
        throw Error(ErrorKind::usage, "the standard input is a terminal; give a file, or a pipe");
    const int from = is_standard_input ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (from < 0) refuse(path, std::strerror(errno));
    const int to = open(std::filesystem::temp_directory_path().c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (to < 0) refuse(path, std::string("no copy of it in the temporary folder: ") + std::strerror(errno));
    copies_.push_back({to, "/proc/self/fd/" + std::to_string(to), path});
    copy(from, to, path);
    if (!is_standard_input) close(from);
    return copies_.back().path;
}

std::string PipedInputs::named(std::string text) const {
    for (const Copy& copy : copies_)
        for (std::size_t at = text.find(copy.path); at != std::string::npos; at = text.find(copy.path, at))
            text.replace(at, copy.path.size(), copy.given);
    return text;
}

}  // namespace hexrelief::cli
