#include "pipeline/cli/printable.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "pipeline/data/clock.h"

namespace hexrelief::cli {
namespace {

constexpr std::size_t kLongest = 2000, kKeptAtTheEnd = 800;

// Returns the length of the UTF-8 character that begins at `at`, and stores its code point; 0 if the
// bytes are no UTF-8.
std::size_t character_at(const std::string& text, std::size_t at, std::uint32_t& code) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    const std::uint8_t first = byte(at);
    const std::size_t length = first < 0x80                    ? 1
                               : first >= 0xc2 && first < 0xe0 ? 2
                               : first >= 0xe0 && first < 0xf0 ? 3
                               : first >= 0xf0 && first < 0xf5 ? 4
                                                               : 0;
    if (length == 0 || at + length > text.size()) return 0;
    code = length == 1 ? first : first & (0x7fu >> length);
    for (std::size_t i = at + 1; i < at + length; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(i) & 0x3fu);
    }
    const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
    return overlong || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff ? 0 : length;
}

bool changes_the_terminal(std::uint32_t code) {
    const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
    const bool direction = code == 0x61c || code == 0x200e || code == 0x200f ||
                           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    return control || direction;
}

void escape(std::string& out, const std::string& text, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
        const auto byte = static_cast<std::uint8_t>(text[i]);
        out += "\\x";
        out += "0123456789abcdef"[byte >> 4];
        out += "0123456789abcdef"[byte & 15];
    }
}

// Returns the beginning and the end of a line that is too long.
std::string shortened(const std::string& line) {
    if (line.size() <= kLongest) return line;
    const auto inside = [&](std::size_t at) { return (static_cast<std::uint8_t>(line[at]) & 0xc0) == 0x80; };
    std::size_t head = kLongest - kKeptAtTheEnd, tail = line.size() - kKeptAtTheEnd;
    while (inside(head)) --head;
    while (inside(tail)) ++tail;
    return line.substr(0, head) + " [...] " + line.substr(tail);
}

}  // namespace

std::string printable(const std::string& text, bool lines) {
    std::string out, line;
    for (std::size_t at = 0; at < text.size();) {
        if (lines && text[at] == '\n') {
            out += shortened(line) + "\n";
            line.clear();
            ++at;
            continue;
        }
        std::uint32_t code = 0;
        const std::size_t length = character_at(text, at, code), taken = length == 0 ? 1 : length;
        if (length == 0 || changes_the_terminal(code))
            escape(line, text, at, at + taken);
        else
            line.append(text, at, taken);
        at += taken;
    }
    return out + shortened(line);
}

void print_error(const std::string& error) {
    std::string text = error;
    std::ranges::replace(text, '\n', ' ');
    std::fprintf(stderr, "hexrelief: %s\n", printable(text).c_str());
}

void print_warning(const std::string& warning) {
    std::fprintf(stderr, "hexrelief: warning: %s\n", printable(warning).c_str());
}

void end_telling() {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
    // What is left in the buffer would fail again at the end.
    static_cast<void>(!std::freopen("/dev/null", "w", stdout));
    print_warning("the standard output is full or closed and takes no summary; the files are written");
}

ProgressLine::~ProgressLine() {
    break_line();
}

void ProgressLine::show(const std::string& stage, double share) {
    const bool is_new = stage != stage_;
    share_ = is_new ? -1 : share;
    if (is_new) begun_ = now_seconds();
    stage_ = stage;
    if (is_new || now_seconds() - drawn_ >= 0.1) draw(false);
}

void ProgressLine::end(const std::string& stage) {
    stage_ = stage;
    draw(true);
    stage_.clear();
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
