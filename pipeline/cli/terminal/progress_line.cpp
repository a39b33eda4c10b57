#include "pipeline/cli/terminal/progress_line.h"

#include <cstdio>

#include "pipeline/data/clock.h"

namespace hexrelief::cli {

ProgressLine::~ProgressLine() {
    break_line();
}

void ProgressLine::begin(const std::string& stage) {
    stage_ = stage;
    share_ = -1;
    begun_ = now_seconds();
    if (enabled_) draw(false);
}

void ProgressLine::update(double share) {
    share_ = share;
    if (enabled_ && now_seconds() - drawn_ >= 0.1) draw(false);
}

void ProgressLine::end() {
    if (enabled_) draw(true);
}

void ProgressLine::break_line() {
    if (open_) std::fputs("\r\x1b[K", stderr);
    open_ = false;
}

void ProgressLine::draw(bool final) {
    drawn_ = now_seconds();
    const double seconds = drawn_ - begun_;
    char share[16] = "     ";
    if (final)
        std::snprintf(share, sizeof share, "100 %%");
    else if (share_ >= 0)
        std::snprintf(share, sizeof share, "%3.0f %%", 100 * share_);
    std::fprintf(stderr, "\r%-11s%s  %6.2f s", stage_.c_str(), share, seconds);
    if (final) std::fputc('\n', stderr);
    open_ = !final;
    std::fflush(stderr);
}

}  // namespace hexrelief::cli
