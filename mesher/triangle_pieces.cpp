#include "mesher/triangle_pieces.h"

#include <algorithm>

namespace hexrelief {

TrianglePieces::Largest TrianglePieces::find(std::span<const PixelRun> rows,
                                             std::vector<std::uint32_t>& piece) {
    pixels_.clear();
    parents_.clear();
    for (const PixelRun& run : rows)
        for (int x = run.first; x < run.end; ++x) {
            parents_.push_back(static_cast<std::uint32_t>(parents_.size()));
            pixels_.push_back(static_cast<std::uint32_t>(view_.index(x, run.y)));
        }
    std::uint32_t i = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const PixelRun below = r + 1 < rows.size() ? rows[r + 1] : PixelRun{};
        const std::uint32_t next = i + static_cast<std::uint32_t>(rows[r].end - rows[r].first);
        for (int x = rows[r].first; x < rows[r].end; ++x, ++i) connect(rows[r], x, i, below, next);
    }
    areas_.assign(parents_.size(), 0);
    Largest largest;
    for (i = 0; i < parents_.size(); ++i) {
        parents_[i] = parents_[parents_[i]];  // its root: parents come first
        piece[pixels_[i]] = pixels_[parents_[i]];
        ++areas_[parents_[i]];
    }
    for (i = 0; i < areas_.size(); ++i)
        if (areas_[i] > largest.area) largest = {pixels_[i], areas_[i]};
    return largest;
}

// Joins a pixel, the i-th, with those on the right and below; next: the number of the row below's first
// pixel.
void TrianglePieces::connect(const PixelRun& run, int x, std::uint32_t i, const PixelRun& below,
                             std::uint32_t next) {
    const std::uint8_t *at = view_.flags + view_.index(x, run.y), *under = at + view_.width;
    const bool right = at[0] & step::kJumpRight, down = at[0] & step::kJumpDown;
    if (!right && x + 1 < run.end) join(i, i + 1);
    const auto holds = [&](int u) { return u >= below.first && u < below.end; };
    const auto number = [&](int u) { return next + static_cast<std::uint32_t>(u - below.first); };
    if (!down && holds(x)) join(i, number(x));
    // diagonally: one of the two ways around the corner is free
    if (holds(x + 1) && ((!right && !(at[1] & step::kJumpDown)) || (!down && !(under[0] & step::kJumpRight))))
        join(i, number(x + 1));
    if (holds(x - 1) &&
        (!(at[-1] & (step::kJumpRight | step::kJumpDown)) || (!down && !(under[-1] & step::kJumpRight))))
        join(i, number(x - 1));
}

std::uint32_t TrianglePieces::root(std::uint32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
}

void TrianglePieces::join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    parents_[std::max(a, b)] = std::min(a, b);
}

}  // namespace hexrelief
