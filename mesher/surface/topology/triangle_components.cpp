#include "mesher/surface/topology/triangle_components.h"

#include <algorithm>

#include "mesher/surface/pixels/crack_query.h"

namespace hexrelief::surface {

TriangleComponents::Largest TriangleComponents::find(std::span<const PixelRun> rows) {
    segments_.clear();
    components_.clear();
    std::size_t above = 0;            // index of the first segment of `upper`
    const PixelRun* upper = nullptr;  // the last row with pixels
    for (const PixelRun& row : rows) {
        if (row.first == row.end) continue;
        const std::size_t first = segments_.size();
        add_row(row);
        if (upper && upper->y + 1 == row.y) connect(*upper, above, row, first);
        if (upper && !touch(*upper, row)) bridge(*upper, above, row, first);
        above = first;
        upper = &row;
    }
    for (std::uint32_t i = 0; i < segments_.size(); ++i) {
        Segment& s = segments_[i];
        s.component = components_.find(i);
        segments_[s.component].area += s.end - s.first;
    }
    Largest largest;
    for (std::uint32_t i = 0; i < segments_.size(); ++i)
        if (const Segment& s = segments_[i]; s.area > largest.area) largest = {s.first, s.area, i};
    return largest;
}

// Divides a row into segments.
void TriangleComponents::add_row(const PixelRun& run) {
    const std::uint32_t start = static_cast<std::uint32_t>(view_.index(run.first, run.y)),
                        end = start + static_cast<std::uint32_t>(run.end - run.first);
    for (std::uint32_t first = start, i = start; i < end; ++i) {
        if (i + 1 < end && !(view_.flags[i] & step::kDiscontinuityRight)) continue;
        segments_.push_back({first, i + 1, 0, 0});
        components_.add();
        first = i + 1;
    }
}

// Joins the connected segments of two successive rows, whose segments begin at `above` and `below`.
void TriangleComponents::connect(const PixelRun& upper, std::size_t above, const PixelRun& lower,
                                 std::size_t below) {
    const std::uint32_t width = static_cast<std::uint32_t>(view_.width);
    const auto free_down = [&](std::uint32_t i) { return !(view_.flags[i] & step::kDiscontinuityDown); };
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
    step::each_diagonal(view_, upper, lower,
                        [&](std::uint32_t i, std::uint32_t j) { meet(above, i, below, j); });
}

// Joins the segment with pixel i, searched from `above` on, and the segment with pixel j,
// searched from `below` on.
void TriangleComponents::meet(std::size_t above, std::uint32_t i, std::size_t below, std::uint32_t j) {
    while (segments_[above].end <= i) ++above;
    while (segments_[below].end <= j) ++below;
    join(above, below);
}

// Joins the nearest segments of two rows with a gap between them, as thin triangles have them, if the path
// from one to the other meets no discontinuity.
void TriangleComponents::bridge(const PixelRun& upper, std::size_t above, const PixelRun& lower,
                                std::size_t below) {
    const auto [x0, x1] = step::bridge_between(upper, lower);
    if (!has_discontinuity(view_, step::way_between_centres(x0, upper.y, x1, lower.y)))
        meet(above, static_cast<std::uint32_t>(view_.index(x0, upper.y)), below,
             static_cast<std::uint32_t>(view_.index(x1, lower.y)));
}

void TriangleComponents::join(std::size_t i, std::size_t j) {
    components_.join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
}

}  // namespace hexrelief::surface
