// Prints the progress of stages on a terminal.
#pragma once

#include <string>

namespace hexrelief::cli {

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
