#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "mesher/sheet_parts.h"
#include "mesher/steps/triangle_sides.h"
#include "mesher/team.h"

namespace hexrelief {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

// Threads look at each other's pixels only where triangles overlap.
std::uint32_t load(const std::uint32_t& place) {
    return std::atomic_ref(const_cast<std::uint32_t&>(place)).load(std::memory_order_relaxed);
}
void store(std::uint32_t& place, std::uint32_t value) {
    std::atomic_ref(place).store(value, std::memory_order_relaxed);
}

}  // namespace

// Every step works on one triangle's own pixels, so that triangles can be shared out among threads.

SideFinder::SideFinder(const PixelSurfaces& surfaces, double cell_px, Team& team)
    : view_(surfaces.view()),
      jump_px_(surfaces.jump_px),
      cell_px_(cell_px),
      nearest_px_(*std::max_element(surfaces.disparity.begin(), surfaces.disparity.end())),
      team_(team),
      places_(surfaces.disparity.size(), 0),
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
        team_.each_piece(changed.size(), thread, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) find_pixels(lattice, changed[i], renewal);
        });
    });
    make_room();
    team_.run([&](int thread) {
        Renewal& renewal = renewals_[thread];
        TrianglePieces pieces(view_);
        const PixelRun* next = renewal.runs.data();
        for (const std::uint32_t t : renewal.triangles) {
            std::copy_n(next, rows_[t].count, runs_.begin() + static_cast<std::ptrdiff_t>(rows_[t].at));
            next += rows_[t].count;
            look_at_pixels(t);
            choose_side(lattice, t, pieces);
        }
        renewal.lost.clear();
        if (team_.size() == 1) return;
        team_.barrier();
        for (const std::uint32_t t : renewal.triangles)
            if (has_lost(t)) renewal.lost.push_back(t);
    });
    TrianglePieces pieces(view_);
    for (const Renewal& renewal : renewals_)
        for (const std::uint32_t t : renewal.lost) choose_side(lattice, t, pieces);
    renewed_.resize(count, 0);
    for (const Renewal& renewal : renewals_)
        for (const std::uint32_t t : renewal.triangles) renewed_[t] = 1;
    lattice.changed.assign(count, SplitLattice::kSame);
}

void SideFinder::open_edges(const SplitLattice& lattice) {
    team_.for_pieces(lattice.triangles.size(), [&](std::size_t first, std::size_t last) {
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
        for (std::size_t i = view_.index(run.first, run.y), end = i + (run.end - run.first); i < end; ++i)
            if (step::belongs(load(places_[i]), t)) store(places_[i], 0);
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

void SideFinder::look_at_pixels(std::uint32_t t) {
    std::uint32_t area = 0, first = kNone;
    std::uint8_t any = 0, all = step::kTrusted;
    const PixelRun* upper = nullptr;
    bool hang_together = true;  // without looking around corners
    for (const PixelRun& run : rows(t)) {
        if (run.first == run.end) continue;
        if (upper && !step::lie_above(*upper, run)) hang_together = false;
        upper = &run;
        const std::size_t start = view_.index(run.first, run.y), end = view_.index(run.end, run.y);
        if (first == kNone) first = static_cast<std::uint32_t>(start);
        area += static_cast<std::uint32_t>(end - start);
        for (std::size_t i = start; i < end; ++i) {
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
    if (plain_[t] || areas_[t] == 0) {
        for (const PixelRun& run : rows(t))
            if (run.first < run.end)
                claim(view_.index(run.first, run.y), view_.index(run.end, run.y), t, true);
    } else {
        const TrianglePieces::Largest largest = pieces.find(rows(t));
        side_[t] = largest.pixel;
        for (const TrianglePieces::Segment& s : pieces.segments())
            claim(s.first, s.end, t, s.parent == largest.segment);
        sides_.mixed[t] = areas_[t] - largest.area >= step::kMixed_px &&
                          stray_error(pieces, largest) > step::kMixedError_px2 * cell_px_;
    }
    const Triangle& v = lattice.triangles[t];
    sides_.anchors[t] = side_[t] == kNone ? step::middle_pixel(view_, lattice.points[v[0]],
                                                               lattice.points[v[1]], lattice.points[v[2]])
                                          : side_[t];
    sides_.kept[t] = view_.disparity[sides_.anchors[t]] > 0;
}

void SideFinder::claim(std::size_t first, std::size_t end, std::uint32_t t, bool on_side) {
    const std::uint32_t place = step::place_of(t, on_side);
    for (std::size_t i = first; i < end; ++i)
        if (load(places_[i]) < place) store(places_[i], place);
}

// Whether another thread wrote a lower number to one of the triangle's pixels at the same time. All are
// there by now.
bool SideFinder::has_lost(std::uint32_t t) const {
    const std::uint32_t least = step::place_of(t, false);
    bool lost = false;
    for (const PixelRun& run : rows(t))
        for (std::size_t i = view_.index(run.first, run.y), end = i + (run.end - run.first); i < end; ++i)
            lost |= places_[i] < least;
    return lost;
}

// What the pixels of other pieces would cost if the side's mean stood for them.
double SideFinder::stray_error(const TrianglePieces& pieces, const TrianglePieces::Largest& largest) const {
    double sum = 0, error = 0;
    for (const TrianglePieces::Segment& s : pieces.segments())
        for (std::uint32_t i = s.first; s.parent == largest.segment && i < s.end; ++i)
            sum += view_.disparity[i];
    const double mean = sum / largest.area;
    for (const TrianglePieces::Segment& s : pieces.segments())
        for (std::uint32_t i = s.first; s.parent != largest.segment && i < s.end; ++i)
            if (view_.flags[i] & step::kTrusted)
                error += step::stray_error(view_.disparity[i], mean, nearest_px_);
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
    const auto pair = [&](std::size_t i, std::size_t j, bool parted) {
        const std::uint32_t other = places_[j];
        if (other == 0) return;
        int k = 0;
        while (k < 3 &&
               !(neighbours[k] >= 0 && step::belongs(other, static_cast<std::uint32_t>(neighbours[k]))))
            ++k;
        if (k == 3) return;
        const int vote =
            step::pair_vote(places_[i] == step::place_of(t, true), step::is_on_side(other), parted);
        votes[k] += vote;
        pairs[k] += vote != 0;
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
    const std::uint32_t i = sides_.anchors[a], j = sides_.anchors[b];
    return step::may_differ(view_, i, j, jump_px_) &&
           step::walk(view_, step::way_between_pixels(view_, i, j)).found;
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
            return places_[start + x] == step::place_of(t, true) && (view_.flags[start + x] & step::kTrusted);
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
        team_.for_pieces(count, [&](std::size_t first, std::size_t last) {
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
