// Ctrl-C and termination: the process ends at once and leaves no partial output.
#pragma once

namespace hexrelief {

inline constexpr int kInterruptedExitCode = 130;

// From now on SIGINT, SIGTERM and SIGHUP (where not ignored) undo the run's outputs and exit with 130. Call
// it before any other thread is started: a thread of its own waits for the signals, so that a stage of
// OpenCV's that never asks is interrupted as well.
void install_interrupt_handling();

// True once a signal has come.
bool interrupted();

// Returns at once where no signal has come, else never: the process is about to exit.
void wait_if_interrupted();

}  // namespace hexrelief
