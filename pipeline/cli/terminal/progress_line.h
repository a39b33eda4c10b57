// The progress line of a stage, on a terminal.
#pragma once

#include <string>

namespace hexrelief::cli {

// One line a stage on stderr, rewritten in place: "mesh        42 %   1.3 s". Silent unless enabled.
class ProgressLine {
  public:
    explicit ProgressLine(bool enabled) : enabled_(enabled) {}
    ~ProgressLine();
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    void begin(const std::string& stage);
    void update(double share);  // 0..1; redraws ten times a second at most
    void end();
    // Clears the line that is half written, so that another text can take its place.
    void break_line();

  private:
    void draw(bool final);
    bool enabled_;
    bool open_ = false;
    std::string stage_;
    double share_ = -1;  // < 0: the stage does not tell
    double begun_ = 0, drawn_ = 0;
};

}  // namespace hexrelief::cli
