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

// One line per stage on stderr, rewritten in place: "mesh        42 %   1.3 s". Silent unless enabled.
class ProgressLine {
  public:
    explicit ProgressLine(bool enabled) : enabled_(enabled) {}
    ~ProgressLine();
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    void begin(const std::string& stage);
    void update(double share);  // 0..1; redraws at most ten times a second
    void end();
    // Clears an unfinished line, so that other text can take its place.
    void break_line();

  private:
    void draw(bool final);
    bool enabled_;
    bool open_ = false;
    std::string stage_;
    double share_ = -1;  // < 0: the stage reports no progress
    double begun_ = 0, drawn_ = 0;
};

}  // namespace hexrelief::cli
