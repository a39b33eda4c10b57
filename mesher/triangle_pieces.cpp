#include "mesher/triangle_pieces.h"

#include <algorithm>

namespace hexrelief {

TrianglePieces::Largest TrianglePieces::find(std::span<const PixelRun> rows,
                                             std::vector<std::uint32_t>& piece) {
    segments_.clear();
    std::size_t above = 0;            // the first segment of the last row with pixels
    const PixelRun* upper = nullptr;  // that row
    for (const PixelRun& row : rows) {
        if (row.first == row.end) continue;
        const std::size_t first = segments_.size();
        add_row(row);
        if (upper && upper->y + 1 == row.y) connect(*upper, above, row, first);
        if (upper && !touch(*upper, row)) bridge(*upper, above, row, first);
        above = first;
        upper = &row;
    }
    for (Segment& s : segments_) {
        s.parent = segments_[s.parent].parent;  // its root: parents come first
        segments_[s.parent].area += s.end - s.first;
    }
    Largest largest;
    for (const Segment& s : segments_) {
        std::fill(piece.begin() + s.first, piece.begin() + s.end, segments_[s.parent].first);
        if (s.area > largest.area) largest = {s.first, s.area};
    }
    return largest;
}

void TrianglePieces::add_row(const PixelRun& run) {
    const std::uint32_t start = static_cast<std::uint32_t>(view_.index(run.first, run.y)),
                        end = start + static_cast<std::uint32_t>(run.end - run.first);
    for (std::uint32_t first = start, i = start; i < end; ++i) {
        if (i + 1 < end && !(view_.flags[i] & step::kJumpRight)) continue;
        segments_.push_back({first, i + 1, static_cast<std::uint32_t>(segments_.size()), 0});
        first = i + 1;
    }
}

// Joins the segments of two rows, numbered from `above` and `below` on.
void TrianglePieces::connect(const PixelRun& upper, std::size_t above, const PixelRun& lower,
                             std::size_t below) {
    const std::uint32_t width = static_cast<std::uint32_t>(view_.width);
    const auto free_down = [&](std::uint32_t i) { return !(view_.flags[i] & step::kJumpDown); };
    const auto free_right = [&](std::uint32_t i) { return !(view_.flags[i] & step::kJumpRight); };
    for (std::size_t a = above, b = below; a < below && b < segments_.size();) {
        std::uint32_t i = std::max(segments_[a].first, segments_[b].first - width);
        const std::uint32_t end = std::min(segments_[a].end, segments_[b].end - width);
        while (i < end && !free_down(i)) ++i;
        if (i < end) join(a, b);
        if (segments_[a].end < segments_[b].end - width)
            ++a;
        else
            ++b;
    }
    // Diagonally, pixels hang together where one of the two ways around their corner is free. Where the pixel
    // on the way is in the triangle, they do so already.
    const auto meet = [&](std::uint32_t i, std::uint32_t j) {
        std::size_t a = above, b = below;
        while (segments_[a].end <= i) ++a;
        while (segments_[b].end <= j) ++b;
        join(a, b);
    };
    const auto at = [&](int x) { return static_cast<std::uint32_t>(view_.index(x, upper.y)); };
    const auto in = [](const PixelRun& run, int x) { return x >= run.first && x < run.end; };
    if (const std::uint32_t i = at(upper.end); in(lower, upper.end) && free_right(i - 1) && free_down(i))
        meet(i - 1, i + width);
    if (const std::uint32_t i = at(upper.first);
        in(lower, upper.first - 1) && free_right(i - 1) && free_down(i - 1))
        meet(i, i - 1 + width);
    if (const std::uint32_t i = at(lower.first) - 1;
        in(upper, lower.first - 1) && free_down(i) && free_right(i + width))
        meet(i, i + 1 + width);
    if (const std::uint32_t i = at(lower.end);
        in(upper, lower.end) && free_down(i) && free_right(i - 1 + width))
        meet(i, i - 1 + width);
}

// Joins the nearest segments of two rows with a gap between them, as thin triangles have them, where the way
// from one to the other meets no jump.
void TrianglePieces::bridge(const PixelRun& upper, std::size_t above, const PixelRun& lower,
                            std::size_t below) {
    const int y0 = upper.y, y1 = lower.y;
    int x0 = upper.first, x1 = lower.end - 1;  // the lower run lies left of the upper one
    std::size_t a = above, b = segments_.size() - 1;
    if (lower.end > upper.first) {
        const int x = std::max(upper.first, lower.first);  // of both runs, unless the lower one lies right
        x0 = std::min(x, upper.end - 1);
        x1 = x;
        while (segments_[a].end <= view_.index(x0, y0)) ++a;
        b = below;
        while (segments_[b].end <= view_.index(x1, y1)) ++b;
    }
    const auto middle = [](int at) { return static_cast<float>(at) + 0.5f; };
    if (!step::walk(view_, middle(x0), middle(y0), middle(x1), middle(y1)).found) join(a, b);
}

std::uint32_t TrianglePieces::root(std::uint32_t i) {
    while (segments_[i].parent != i) i = segments_[i].parent = segments_[segments_[i].parent].parent;
    return i;
}

void TrianglePieces::join(std::size_t i, std::size_t j) {
    const std::uint32_t a = root(static_cast<std::uint32_t>(i)), b = root(static_cast<std::uint32_t>(j));
    segments_[std::max(a, b)].parent = std::min(a, b);
}

}  // namespace hexrelief
