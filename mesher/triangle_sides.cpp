#include <algorithm>
#include <cmath>
#include <numeric>

#include "mesher/sheet_parts.h"
#include "mesher/team.h"
#include "mesher/triangle_pieces.h"

namespace hexrelief {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
// A triangle is mixed, and worth more vertices, with so many pixels of other sides that cost more than an
// error of kMixedError_px2 all over a lattice cell would.
constexpr std::uint32_t kMixed_px = 2;
constexpr double kMixedError_px2 = 0.5;
constexpr double kMostError_px = 10;  // of a pixel: more is just wrong, as is a hole
constexpr double kHoleWeight = 0.7;   // of a covered hole, as a share of the disparity that covers it

std::uint32_t middle_pixel(const step::PixelView& view, const SplitLattice& lattice, std::uint32_t t) {
    const Triangle& v = lattice.triangles[t];
    const auto& p = lattice.points;
    const int x = static_cast<int>((p[v[0]].x + p[v[1]].x + p[v[2]].x) / 3),
              y = static_cast<int>((p[v[0]].y + p[v[1]].y + p[v[2]].y) / 3);
    return static_cast<std::uint32_t>(
        view.index(std::clamp(x, 0, view.width - 1), std::clamp(y, 0, view.height - 1)));
}

}  // namespace

// Every step works on one triangle's own pixels, so that triangles can be shared out among threads.

SideFinder::SideFinder(const PixelSurfaces& surfaces, double cell_px, Team& team)
    : view_(surfaces.view()),
      jump_px_(surfaces.jump_px),
      cell_px_(cell_px),
      nearest_px_(*std::max_element(surfaces.disparity.begin(), surfaces.disparity.end())),
      team_(team),
      owner_(surfaces.disparity.size(), kNone),
      piece_(surfaces.disparity.size()),
      renewals_(team.size()) {}

void SideFinder::update(SplitLattice& lattice) {
    const std::size_t count = lattice.triangles.size();
    std::vector<std::uint32_t> changed;
    for (std::uint32_t t = 0; t < count; ++t)
        if (lattice.changed[t] != SplitLattice::kSame) changed.push_back(t);
    side_.resize(count, kNone);
    sides_.anchors.resize(count);
    areas_.resize(count, 0);
    plain_.resize(count, 0);
    trusted_.resize(count, 0);
    rows_.resize(count);
    sides_.kept.resize(count, 0);
    sides_.mixed.resize(count, 0);
    sides_.open.resize(count, {0, 0, 0});
    team_.run([&](int thread) {
        Renewal& renewal = renewals_[thread];
        renewal.runs.clear();
        renewal.triangles.clear();
        const std::size_t end = team_.share(changed.size(), thread + 1);
        for (std::size_t i = team_.share(changed.size(), thread); i < end; ++i)
            find_pixels(lattice, changed[i], renewal);
    });
    make_room();
    team_.run([&](int thread) {
        TrianglePieces pieces(view_);
        const PixelRun* next = renewals_[thread].runs.data();
        for (const std::uint32_t t : renewals_[thread].triangles) {
            std::copy_n(next, rows_[t].count, runs_.begin() + static_cast<std::ptrdiff_t>(rows_[t].at));
            next += rows_[t].count;
            own_pixels(t);
            choose_side(lattice, t, pieces);
        }
    });
    renewed_.resize(count, 0);
    for (const Renewal& renewal : renewals_)
        for (const std::uint32_t t : renewal.triangles) renewed_[t] = 1;
    lattice.changed.assign(count, SplitLattice::kSame);
}

void SideFinder::open_edges(const SplitLattice& lattice) {
    team_.for_ranges(lattice.triangles.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t t = first; t < last; ++t) {
            const auto& n = lattice.neighbours[t];
            const auto is_new = [&](std::int32_t u) { return u >= 0 && renewed_[u]; };
            if (renewed_[t] || is_new(n[0]) || is_new(n[1]) || is_new(n[2]))
                vote(lattice, static_cast<std::uint32_t>(t));
        }
    });
    renewed_.assign(lattice.triangles.size(), 0);
}

// Most triangles at rims move by so little that they keep their pixels, and with them all that follows.
// Others leave theirs.
void SideFinder::find_pixels(const SplitLattice& lattice, std::uint32_t t, Renewal& renewal) {
    const Triangle& v = lattice.triangles[t];
    const std::size_t start = renewal.runs.size();
    each_run(view_.width, view_.height, lattice.points[v[0]], lattice.points[v[1]], lattice.points[v[2]],
             [&](const PixelRun& run) { renewal.runs.push_back(run); });
    const std::span<const PixelRun> old = rows(t);
    if (lattice.changed[t] == SplitLattice::kMoved && areas_[t] > 0 &&
        std::equal(old.begin(), old.end(), renewal.runs.begin() + static_cast<std::ptrdiff_t>(start),
                   renewal.runs.end())) {
        renewal.runs.resize(start);
        return;
    }
    for (const PixelRun& run : old)
        std::fill_n(owner_.begin() + static_cast<std::ptrdiff_t>(view_.index(run.first, run.y)),
                    run.end - run.first, kNone);
    rows_[t].count = static_cast<std::uint32_t>(renewal.runs.size() - start);
    renewal.triangles.push_back(t);
}

// For the rows of triangles that have more than before, at the end.
void SideFinder::make_room() {
    std::size_t end = runs_.size();
    for (const Renewal& renewal : renewals_)
        for (const std::uint32_t t : renewal.triangles) {
            Rows& rows = rows_[t];
            if (rows.count <= rows.room) continue;
            rows.at = end;
            rows.room = rows.count;
            end += rows.room;
        }
    runs_.resize(end);
}

void SideFinder::own_pixels(std::uint32_t t) {
    std::uint32_t area = 0, first = kNone;
    std::uint8_t any = 0, all = step::kTrusted;
    const PixelRun* upper = nullptr;
    bool hang_together = true;  // without looking around corners
    for (const PixelRun& run : rows(t)) {
        if (run.first == run.end) continue;
        if (upper && !(upper->y + 1 == run.y && upper->first < run.end && run.first < upper->end))
            hang_together = false;
        upper = &run;
        const std::size_t start = view_.index(run.first, run.y), end = view_.index(run.end, run.y);
        if (first == kNone) first = static_cast<std::uint32_t>(start);
        area += static_cast<std::uint32_t>(end - start);
        for (std::size_t i = start; i < end; ++i) {
            owner_[i] = t;
            piece_[i] = first;
            any |= view_.flags[i];
            all &= view_.flags[i];
        }
    }
    areas_[t] = area;
    side_[t] = first;
    plain_[t] = hang_together && !(any & (step::kJumpRight | step::kJumpDown));
    trusted_[t] = all;
}

// The largest piece of a triangle is its side; a triangle without pixels lies where its middle does.
void SideFinder::choose_side(const SplitLattice& lattice, std::uint32_t t, TrianglePieces& pieces) {
    sides_.mixed[t] = 0;
    if (!plain_[t] && areas_[t] > 0) {
        const TrianglePieces::Largest largest = pieces.find(rows(t), piece_);
        side_[t] = largest.pixel;
        sides_.mixed[t] = areas_[t] - largest.area >= kMixed_px &&
                          stray_error(t, largest.area) > kMixedError_px2 * cell_px_;
    }
    sides_.anchors[t] = side_[t] == kNone ? middle_pixel(view_, lattice, t) : side_[t];
    sides_.kept[t] = view_.disparity[sides_.anchors[t]] > 0;
}

// What the pixels of other pieces would cost if the side's mean stood for them: squared, near-weighted.
double SideFinder::stray_error(std::uint32_t t, std::uint32_t own_px) const {
    double sum = 0, error = 0;
    const auto each_pixel = [&](const auto& visit) {
        for (const PixelRun& run : rows(t))
            for (std::size_t i = view_.index(run.first, run.y), end = i + (run.end - run.first); i < end; ++i)
                visit(i);
    };
    each_pixel([&](std::size_t i) { sum += piece_[i] == side_[t] ? view_.disparity[i] : 0; });
    const double mean = sum / own_px;
    each_pixel([&](std::size_t i) {
        if (piece_[i] == side_[t] || !(view_.flags[i] & step::kTrusted)) return;
        const double d = view_.disparity[i];
        const double e = d > 0 && mean > 0 ? step::min_of(std::fabs(d - mean), kMostError_px) : kMostError_px;
        const double near = (d > 0 ? d : kHoleWeight * mean) / nearest_px_;
        error += near * near * near * e * e;
    });
    return error;
}

// Pairs of neighbouring pixels across each edge say whether its two sides are one surface.
void SideFinder::vote(const SplitLattice& lattice, std::uint32_t t) {
    sides_.open[t] = {0, 0, 0};
    const auto& neighbours = lattice.neighbours[t];
    if (plain_[t] && areas_[t] > 0 && std::all_of(neighbours.begin(), neighbours.end(), [&](std::int32_t n) {
            return n < 0 || (plain_[n] && areas_[n] > 0);
        }))
        return;
    std::array<int, 3> votes{0, 0, 0}, pairs{0, 0, 0};
    const std::uint32_t side = side_[t];
    const auto pair = [&](std::size_t i, std::size_t j, bool parted) {
        const std::uint32_t other = owner_[j];
        if (other == kNone) return;
        int k = 0;
        while (k < 3 && neighbours[k] != static_cast<std::int32_t>(other)) ++k;
        if (k == 3) return;
        const bool own = piece_[i] == side, others = piece_[j] == side_[other];
        // without a jump to the lesser part, the one's surface goes on beyond the edge
        if (!(own && others) && (parted || !(own || others))) return;
        votes[k] += own && others && !parted ? -1 : 1;
        ++pairs[k];
    };
    const std::size_t width = static_cast<std::size_t>(view_.width);
    const std::uint8_t* flags = view_.flags;
    const std::span<const PixelRun> runs = rows(t);
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const PixelRun& run = runs[r];
        if (run.first == run.end) continue;
        const std::size_t start = view_.index(0, run.y), first = start + run.first,
                          last = start + run.end - 1;
        if (run.first > 0) pair(first, first - 1, flags[first - 1] & step::kJumpRight);
        if (run.end < view_.width) pair(last, last + 1, flags[last] & step::kJumpRight);
        // of the rows above and below, what lies beyond the triangle's own pixels
        const auto each_beyond = [&](const PixelRun& other, const auto& visit) {
            for (int x = run.first; x < std::min(run.end, other.first); ++x) visit(start + x);
            for (int x = std::max(run.first, other.end); x < run.end; ++x) visit(start + x);
        };
        if (run.y > 0)
            each_beyond(r > 0 ? runs[r - 1] : PixelRun{},
                        [&](std::size_t i) { pair(i, i - width, flags[i - width] & step::kJumpDown); });
        if (run.y + 1 < view_.height)
            each_beyond(r + 1 < runs.size() ? runs[r + 1] : PixelRun{},
                        [&](std::size_t i) { pair(i, i + width, flags[i] & step::kJumpDown); });
    }
    for (int k = 0; k < 3; ++k) {
        if (neighbours[k] < 0) continue;
        sides_.open[t][k] =
            pairs[k] > 0 ? votes[k] > 0 : differ(t, static_cast<std::uint32_t>(neighbours[k]));
    }
}

// Without pixels along the edge: whether a jump parts the triangles' own pixels.
bool SideFinder::differ(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t i = sides_.anchors[a], j = sides_.anchors[b],
                        w = static_cast<std::uint32_t>(view_.width);
    if (!step::is_jump(view_.disparity[i], view_.disparity[j], jump_px_)) return false;
    const auto middle = [](std::uint32_t at) { return static_cast<float>(at) + 0.5f; };
    return step::walk(view_, middle(i % w), middle(i / w), middle(j % w), middle(j / w)).found;
}

// Calls visit(run) for the runs of a triangle's pixels that lie on its side and are no specks.
template <typename Visit>
void SideFinder::each_fitted(std::uint32_t t, const Visit& visit) {
    for (const PixelRun& run : rows(t)) {
        if (plain_[t] && trusted_[t]) {
            if (run.first < run.end) visit(run);
            continue;
        }
        const std::size_t start = view_.index(0, run.y);
        const auto fitted = [&](int x) {
            return piece_[start + x] == side_[t] && (view_.flags[start + x] & step::kTrusted);
        };
        for (int x = run.first; x < run.end;) {
            const int first = x;
            while (x < run.end && fitted(x)) ++x;
            if (first < x)
                visit(PixelRun{run.y, first, x});
            else
                ++x;
        }
    }
}

void SideFinder::collect_pixels(const SplitLattice& lattice) {
    const std::size_t count = lattice.triangles.size();
    const auto each_kept = [&](const auto& work) {
        team_.for_ranges(count, [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t)
                if (sides_.kept[t]) work(static_cast<std::uint32_t>(t));
        });
    };
    sides_.starts.assign(count + 1, 0);
    each_kept([&](std::uint32_t t) { each_fitted(t, [&](const PixelRun&) { ++sides_.starts[t + 1]; }); });
    std::partial_sum(sides_.starts.begin(), sides_.starts.end(), sides_.starts.begin());
    sides_.runs.resize(sides_.starts.back());
    each_kept([&](std::uint32_t t) {
        PixelRun* next = sides_.runs.data() + sides_.starts[t];
        each_fitted(t, [&](const PixelRun& run) { *next++ = run; });
    });
}

}  // namespace hexrelief
