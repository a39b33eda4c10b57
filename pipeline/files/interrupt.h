// Ctrl-C and termination: the process ends at once and leaves no partial output.
#pragma once

namespace hexrelief::files {

inline constexpr int kInterruptedExitCode = 130;

// To be called first of all. A standard stream that is closed is opened so that it can be neither read nor
// written, lest the first file that is opened take its place and receive what is printed. Where a file grows
// beyond what the process may write, that is an error of the write and not the process's end by SIGXFSZ.
void guard_standard_streams();

// From now on SIGINT, SIGTERM and SIGHUP (where not ignored) undo the run's outputs and exit with 130. Call
// it before any other thread is started: a thread of its own waits for the signals, so that a stage of
// OpenCV's that never asks is interrupted as well. Where the system gives no thread, a signal's handler does
// it, and leaves folders that were made. A reader that closes its pipe is an error of the write from now on.
void install_interrupt_handling();

// True once a signal has come.
bool interrupted();

// Returns at once where no signal has come, else never: the process is about to exit.
void wait_if_interrupted();

}  // namespace hexrelief::files
