// The only exception type of the libraries; its kind decides the process's exit code.
#pragma once

#include <stdexcept>
#include <string>

namespace hexrelief {

// The values are the process's exit codes. Any other exception is a bug and exits with 1.
enum class ErrorKind {
    usage = 2,   // command line or configuration
    input = 3,   // a file that cannot be read or used
    output = 4,  // a file that cannot be written
    device = 5,  // a compute device that is missing or fails
};

// The message is one line: what is wrong, at which file, key or value, and what to do about it.
class Error : public std::runtime_error {
  public:
    Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
    ErrorKind kind() const noexcept { return kind_; }

  private:
    ErrorKind kind_;
};

}  // namespace hexrelief
