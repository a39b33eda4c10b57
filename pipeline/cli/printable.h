// Makes text with names and values from outside safe for a terminal.
#pragma once

#include <string>

namespace hexrelief::cli {

// Replaces control characters, marks that change the direction of writing and bytes that are no UTF-8 by
// "\x1b" and the like, so that a file's name cannot move the cursor, change colours or imitate other output.
// Line feeds are kept if `lines` is true. A very long line keeps its beginning and its end.
std::string printable(const std::string& text, bool lines = false);

// Print "hexrelief: ..." and "hexrelief: warning: ..." to standard error, as one line.
void print_error(const std::string& error);
void print_warning(const std::string& warning);

// Ends what a command prints about files that are written. If the standard output takes nothing, being full
// or closed, that is warned of, and is no error.
void end_telling();

// One line per stage on stderr, rewritten in place: "mesh        42 %   1.3 s".
class ProgressLine {
  public:
    ProgressLine() = default;
    ~ProgressLine();
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    // Shows a stage, first with the share 0, then at most ten times a second.
    void show(const std::string& stage, double share);
    void end(const std::string& stage);
    // Clears an unfinished line, so that other text can take its place.
    void break_line();

  private:
    void draw(bool final);
    bool open_ = false;
    std::string stage_;  // empty = none is shown
    double share_ = -1;  // < 0: the stage reports no progress
    double begun_ = 0, drawn_ = 0;
};

}  // namespace hexrelief::cli
