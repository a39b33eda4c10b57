#include "pipeline/files/interrupt.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <mutex>
#include <set>
#include <string>
#include <system_error>
#include <thread>

#include "exporters/core/file_transaction.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"

namespace hexrelief::files {
namespace {

namespace fs = std::filesystem;

std::mutex temporary_mutex;
std::set<fs::path> temporary_folders;

std::atomic<bool> signalled{false};

void end_by_signal(int) {
    signalled = true;
    exporters::remove_pending_files();
    _exit(kInterruptedExitCode);
}

void await_signals(const sigset_t& awaited) {
    std::thread([awaited] {
        int number = 0;
        while (sigwait(&awaited, &number) != 0) {
        }
        signalled = true;
        roll_back_outputs();
        remove_temporary_folders();
        _exit(kInterruptedExitCode);  // no destructors: the other threads are still at work
    }).detach();
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
    const std::lock_guard lock(temporary_mutex);
    std::error_code code;
    std::string name = (fs::temp_directory_path(code) / "hexrelief-XXXXXX").string();
    if (code || !mkdtemp(name.data()))
        throw Error(ErrorKind::output, "cannot make the temporary folder " + name + ": " +
                                           std::generic_category().message(code ? code.value() : errno) +
                                           "; TMPDIR names another place");
    path_ = *temporary_folders.insert(name).first;
}

TemporaryFolder::~TemporaryFolder() {
    const std::lock_guard lock(temporary_mutex);
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    temporary_folders.erase(path_);
}

void remove_temporary_folders() {
    const std::lock_guard lock(temporary_mutex);
    std::error_code ignored;
    for (const fs::path& folder : temporary_folders) fs::remove_all(folder, ignored);
    temporary_folders.clear();
}

void guard_standard_streams() {
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        // The lowest free number is that of the closed stream. A file that is open only in the other
        // direction fails as a closed one does.
        if (fcntl(descriptor, F_GETFD) == -1 && errno == EBADF)
            static_cast<void>(open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY));
    }
    std::signal(SIGXFSZ, SIG_IGN);
}

void install_interrupt_handling() {
    sigset_t awaited;
    sigemptyset(&awaited);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction action = {};
        sigaction(number, nullptr, &action);
        // Ignored by nohup or in a shell's background job.
        if (action.sa_handler != SIG_IGN) sigaddset(&awaited, number);
    }
    pthread_sigmask(SIG_BLOCK, &awaited, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    try {
        await_signals(awaited);
    } catch (const std::system_error&) {
        struct sigaction action = {};
        action.sa_handler = end_by_signal;
        sigfillset(&action.sa_mask);
        for (const int number : {SIGINT, SIGTERM, SIGHUP})
            if (sigismember(&awaited, number) == 1) sigaction(number, &action, nullptr);
        pthread_sigmask(SIG_UNBLOCK, &awaited, nullptr);
    }
}

bool interrupted() {
    return signalled;
}

void wait_if_interrupted() {
    while (signalled) pause();
}

}  // namespace hexrelief::files
