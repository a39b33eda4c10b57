#include "pipeline/job/pairs/dark_strips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

namespace hexrelief::job {
namespace {

constexpr int kDark = 8;        // JPEG blurs black by a few levels
constexpr int kBright = 24;     // at the strip's end
constexpr int kBlurred_px = 3;  // between the two
constexpr int kLeastWidth_px = 2;
constexpr double kLargestWidth = 0.25;  // of the picture
constexpr int kSmooth_px = 2;           // change of the width from one line to the next
constexpr double kMostOdd = 0.03;       // lines that end otherwise
constexpr double kLeastLines = 0.5;     // that are not dark from end to end
constexpr double kLeastWedge = 0.125;   // of the lines
constexpr double kMostBent = 0.1;       // off a straight line, of the wedge's width

int level(const Image& image, int x, int y) {
    const std::uint8_t* const pixel = image.at(x, y);
    return *std::max_element(pixel, pixel + image.channels);
}

// One of the four sides. Lines run from it across the picture, pixels are counted from it.
struct Side {
    const Image& image;
    bool is_vertical, is_far;  // left and right; right and bottom

    int lines() const { return is_vertical ? image.height : image.width; }
    int length() const { return is_vertical ? image.width : image.height; }
    std::pair<int, int> place(int line, int at) const {
        const int across = is_far ? length() - 1 - at : at;
        return is_vertical ? std::pair{across, line} : std::pair{line, across};
    }
    int level_at(int line, int at) const {
        const auto [x, y] = place(line, at);
        return level(image, x, y);
    }
};

// Returns the number of dark pixels at each line's beginning.
std::vector<int> dark_runs(const Side& side) {
    std::vector<int> runs(static_cast<std::size_t>(side.lines()));
    for (int line = 0; line < side.lines(); ++line) {
        int& run = runs[static_cast<std::size_t>(line)];
        while (run < side.length() && side.level_at(line, run) <= kDark) ++run;
    }
    return runs;
}

bool ends_at_once(const Side& side, int line, int run) {
    for (int at = run; at < std::min(run + kBlurred_px, side.length()); ++at)
        if (side.level_at(line, at) >= kBright) return true;
    return false;
}

bool is_strip(const Side& side, const std::vector<int>& runs) {
    int lines = 0, odd = 0, before = -1;
    for (int line = 0; line < side.lines(); ++line) {
        const int run = runs[static_cast<std::size_t>(line)];
        if (run == side.length()) continue;
        ++lines;
        odd += run < kLeastWidth_px || run > kLargestWidth * side.length() ||
               (before >= 0 && std::abs(run - before) > kSmooth_px) || !ends_at_once(side, line, run);
        before = run;
    }
    return lines > kLeastLines * side.lines() && odd <= kMostOdd * lines;
}

struct Lines {
    int first = 0, end = 0;
};

// Returns the lines of a wedge, which is widest at the first or the last line and becomes thinner along a
// nearly straight line until it ends; none if there is no such wedge.
Lines find_wedge(const Side& side, const std::vector<int>& runs, bool is_widest_last) {
    const int count = side.lines();
    const auto line_of = [&](int i) { return is_widest_last ? count - 1 - i : i; };
    const auto run_of = [&](int i) { return runs[static_cast<std::size_t>(line_of(i))]; };
    int first = 0;
    while (first < count && run_of(first) == side.length()) ++first;
    int end = first;
    while (end < count && run_of(end) >= kLeastWidth_px && run_of(end) < side.length()) ++end;
    if (end == count || end - first < kLeastWedge * count) return {};
    const int widest = run_of(first), thinnest = run_of(end - 1);
    if (widest < 2 * kLeastWidth_px || widest > kLargestWidth * side.length() ||
        thinnest > kLeastWidth_px + kSmooth_px)
        return {};
    int odd = 0;
    for (int i = first; i < end; ++i) {
        const double straight = widest + double(thinnest - widest) * (i - first) / (end - first);
        odd += std::abs(run_of(i) - straight) > kSmooth_px + kMostBent * widest ||
               (i > first && std::abs(run_of(i) - run_of(i - 1)) > kSmooth_px) ||
               !ends_at_once(side, line_of(i), run_of(i));
    }
    if (odd > kMostOdd * (end - first)) return {};
    return is_widest_last ? Lines{count - end, count - first} : Lines{first, end};
}

// Returns the lines that a strip along the whole side covers, or the wedges at its two ends.
std::array<Lines, 2> dark_lines(const Side& side, const std::vector<int>& runs) {
    if (is_strip(side, runs)) return {Lines{0, side.lines()}};
    return {find_wedge(side, runs, false), find_wedge(side, runs, true)};
}

}  // namespace

readers::PixelMask without_dark_strips(const Image& image) {
    readers::PixelMask mask;
    for (const auto& [is_vertical, is_far] :
         {std::pair{true, false}, {true, true}, {false, false}, {false, true}}) {
        const Side side{image, is_vertical, is_far};
        const std::vector<int> runs = dark_runs(side);
        for (const auto& [first, end] : dark_lines(side, runs)) {
            if (first == end) continue;
            if (mask.empty())
                mask = {image.width, image.height,
                        std::vector<std::uint8_t>(image.pixels.size() / image.channels, 1)};
            for (int line = first; line < end; ++line)
                for (int at = 0; at < runs[static_cast<std::size_t>(line)]; ++at) {
                    const auto [x, y] = side.place(line, at);
                    mask.kept[static_cast<std::size_t>(y) * image.width + x] = 0;
                }
        }
    }
    return mask;
}

}  // namespace hexrelief::job
