// A program of the user's that this one starts, waits for and ends.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::job {

// A running program: its standard input and output are this process's to write and to read, its standard
// error is kept for messages. It has a process group of its own, and ends with this process, whatever ends
// that.
class ChildProgram {
  public:
    // Starts words[0], looked up in PATH, without a shell. name: how messages begin. Throws Error(input) if
    // it cannot be started.
    ChildProgram(std::vector<std::string> words, std::string name);
    ChildProgram(const ChildProgram&) = delete;
    ChildProgram& operator=(const ChildProgram&) = delete;
    ~ChildProgram();  // kills the program and all that it started

    // Writes a line to the program. Throws Error(input) if the program reads no more.
    void write_line(const std::string& line);
    // Returns the next line that the program prints. Throws Error(input) if the program ends, prints more
    // than 64 KiB without a line end, or prints no whole line within the time.
    std::string read_line(double timeout_s);
    // Closes the program's input, reads what it prints and waits for its end. Throws Error(input) if it has
    // not ended within the time, or ends with another exit code than 0.
    void finish(double timeout_s);

  private:
    // Reads what there is into the buffers, for at most `wait_ms`. Returns false once both streams are at
    // their end.
    bool read_some(int wait_ms);
    void read_rest();  // what a program that ended has left in its streams
    void take(int& stream, std::string& kept);
    [[noreturn]] void fail(const std::string& what);
    [[noreturn]] void fail_by_status();
    std::string last_words() const;  // ": " and the last line that it printed for people; or nothing
    bool has_ended();
    void end();

    std::vector<std::string> words_;
    std::string name_;
    int process_ = -1, input_ = -1, output_ = -1, errors_ = -1;
    int status_ = 0;
    std::string printed_, complaints_;
};

}  // namespace hexrelief::job
