// Inputs from pipes: `--left -`, `--left <(...)`.
#pragma once

#include <string>
#include <vector>

#include "pipeline/library/run.h"

namespace hexrelief::cli {

// Copies of what came through pipes, in files without a name, which go with this object. Readers open an
// input several times, and at any place, which no pipe allows.
class PipedInputs {
  public:
    PipedInputs() = default;
    PipedInputs(const PipedInputs&) = delete;
    PipedInputs& operator=(const PipedInputs&) = delete;
    ~PipedInputs();

    // Returns the path of a copy if `path` is "-", the standard input, or a pipe of a shell, /dev/fd/N; else
    // `path`. Pipes in folders stay, because nobody may ever write to them. Throws Error(input) if the pipe
    // cannot be read, holds more than 4 GiB or the temporary folder is full, and Error(usage) if one is asked
    // for twice, or the standard input is a terminal.
    std::string file_of(const std::string& path);
    // Returns the text with the copies' paths replaced by what was given.
    std::string named(std::string text) const;

  private:
    struct Copy {
        int file;
        std::string path, given;
    };
    std::vector<Copy> copies_;
};

}  // namespace hexrelief::cli
