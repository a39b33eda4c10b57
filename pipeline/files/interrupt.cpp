#include "pipeline/files/interrupt.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <initializer_list>
#include <thread>

#include "pipeline/files/output_set.h"

namespace hexrelief {
namespace {

std::atomic<bool> signalled{false};

}  // namespace

void install_interrupt_handling() {
    sigset_t awaited;
    sigemptyset(&awaited);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction action = {};
        sigaction(number, nullptr, &action);
        if (action.sa_handler != SIG_IGN) sigaddset(&awaited, number);  // nohup, a shell's background job
    }
    pthread_sigmask(SIG_BLOCK, &awaited, nullptr);
    std::thread([awaited] {
        int number = 0;
        while (sigwait(&awaited, &number) != 0) {
        }
        signalled = true;
        roll_back_outputs();
        _exit(kInterruptedExitCode);  // no destructors: the other threads are still at work
    }).detach();
}

bool interrupted() {
    return signalled;
}

void wait_if_interrupted() {
    while (signalled) pause();
}

}  // namespace hexrelief
