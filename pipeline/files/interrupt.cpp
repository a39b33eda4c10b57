#include "pipeline/files/interrupt.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <thread>

#include "exporters/core/file_transaction.h"
#include "pipeline/files/output_set.h"
#include "pipeline/files/temporary_folder.h"

namespace hexrelief::files {
namespace {

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
