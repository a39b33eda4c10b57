// Handles Ctrl-C and termination: the process ends at once and leaves no partial output. A TemporaryFolder is
// removed then as well.
#pragma once

#include <filesystem>

namespace hexrelief::files {

// A folder that only this user may open, in the system's place for temporary files. It is removed with all
// that is in it by the destructor, and if the process is interrupted.
class TemporaryFolder {
  public:
    // Throws Error(output) if no folder can be made.
    TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder();
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

// Removes the folders of this process; called by the interrupt's thread.
void remove_temporary_folders();

inline constexpr int kInterruptedExitCode = 130;

// Opens each standard stream that is closed, so that it can be neither read nor written; otherwise the first
// file opened would take its place and receive what is printed. Also makes a file beyond the process's size
// limit an error of the write, instead of the process's end by SIGXFSZ. To be called first of all.
void guard_standard_streams();

// From now on SIGINT, SIGTERM and SIGHUP (unless ignored) undo the run's outputs and exit with 130. To be
// called before any other thread is started: a thread of its own waits for the signals, so that a stage of
// OpenCV, which never checks for them, is interrupted as well. If the system gives no thread, a signal
// handler does the work; it does not remove folders that were made. A reader that closes its pipe becomes an
// error of the write.
void install_interrupt_handling();

// True once a signal has come.
bool interrupted();

// Returns at once if no signal has come, else never: the process is about to exit.
void wait_if_interrupted();

}  // namespace hexrelief::files
