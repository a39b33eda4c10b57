#include <algorithm>
#include <atomic>
#include <numeric>

#include "mesher/surface/pixels/crack_query.h"
#include "mesher/surface/pixels/eight_flags.h"
#include "mesher/surface/topology/label_triangles.h"
#include "mesher/surface/topology/rasterize.h"
#include "mesher/surface/topology/split_triangles_step.h"

namespace hexrelief::surface {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

// The threads access ids atomically, because they read and write each other's pixels if triangles overlap.
std::uint32_t load(const std::uint32_t& id) {
    return std::atomic_ref(const_cast<std::uint32_t&>(id)).load(std::memory_order_relaxed);
}
void store(std::uint32_t& id, std::uint32_t value) {
    std::atomic_ref(id).store(value, std::memory_order_relaxed);
}
// Writes `id` to pixels; if two triangles share a pixel, the higher id stays.
void write_id(std::uint32_t* ids, std::size_t count, std::uint32_t id) {
    for (std::size_t i = 0; i < count; ++i)
        if (load(ids[i]) < id) store(ids[i], id);
}

}  // namespace

// Each step works on the pixels of one triangle, so the threads share the triangles.

TriangleLabeler::TriangleLabeler(const PixelSurfaces& surfaces, double cell_px, float nearest_px,
                                 ThreadPool& pool)
    : view_(surfaces.view()),
      discontinuity_px_(surfaces.discontinuity_px),
      cell_px_(cell_px),
      pool_(pool),
      work_(static_cast<std::size_t>(pool.size()), ThreadWork(view_)) {
    const std::size_t pixels = surfaces.disparity.size();
    triangle_ids_.resize(pixels);
    std::vector<float> nearest(static_cast<std::size_t>(pool.size()));
    pool.run([&](int thread) {
        const std::size_t first = pool.share(pixels, thread), end = pool.share(pixels, thread + 1);
        std::fill(triangle_ids_.begin() + static_cast<std::ptrdiff_t>(first),
                  triangle_ids_.begin() + static_cast<std::ptrdiff_t>(end), 0u);
        float most = nearest_px;
        for (std::size_t i = first; i < end; ++i) most = std::max(most, surfaces.disparity[i]);
        nearest[static_cast<std::size_t>(thread)] = most;
    });
    nearest_px_ = *std::max_element(nearest.begin(), nearest.end());
}

void TriangleLabeler::update(SplitLattice& lattice) {
    const std::size_t count = lattice.triangles.size(), before = rows_.size();
    const auto each_vector = [&](const auto& visit) {
        visit(rows_), visit(label_pixels_), visit(areas_), visit(plain_), visit(whole_), visit(trusted_);
        visit(renewed_), visit(labels_.anchors), visit(labels_.kept), visit(labels_.straddling),
            visit(labels_.open);
    };
    each_vector([&](auto& v) {
        v.reserve(lattice.triangles.capacity());
        v.resize(count);
    });
    ThreadPool::ChunkCounters chunk_counters(pool_.size());
    pool_.run([&](int thread) {
        ThreadWork& work = work_[thread];
        work.triangles.clear();
        work.labelled.clear();
        each_vector([&](auto& v) {
            const std::size_t first = before + pool_.share(count - before, thread),
                              end = before + pool_.share(count - before, thread + 1);
            for (std::size_t t = first; t < end; ++t) v[t] = {};
        });
        pool_.barrier();
        pool_.run_chunks(count, thread, chunk_counters, [&](std::size_t i) {
            if (lattice.changed[i] == step::kSame) return;
            const std::uint32_t t = static_cast<std::uint32_t>(i);
            if (rasterize(lattice, t, work)) label(lattice, t, work);
            lattice.changed[t] = step::kSame;
        });
        pool_.barrier();  // all triangles have cleared the pixels that they had before
        std::size_t next = 0;
        for (const std::uint32_t t : work.triangles) write_ids(t, work.labelled, next);
        work.overwritten.clear();
        if (pool_.size() == 1) return;
        pool_.barrier();
        for (const std::uint32_t t : work.triangles)
            if (is_overwritten(t)) work.overwritten.push_back(t);
    });
    for (ThreadWork& work : work_)
        for (const std::uint32_t t : work.overwritten) {
            std::size_t next = 0;
            work.labelled.clear();
            label(lattice, t, work);
            write_ids(t, work.labelled, next);
        }
}

// Each triangle's pixels vote on its own edges. Two overlapping triangles may disagree about their edge; the
// result of the lower one holds.
void TriangleLabeler::open_edges(const SplitLattice& lattice) {
    const std::size_t count = lattice.triangles.size();
    pool_.parallel_for_chunks(count, [&](std::size_t t) {
        const auto& n = lattice.neighbours[t];
        const std::int32_t own = static_cast<std::int32_t>(t);
        if (n[0] < own && n[1] < own && n[2] < own) return;
        const bool is_due = renewed_[t] || std::any_of(n.begin(), n.end(),
                                                       [&](std::int32_t u) { return u >= 0 && renewed_[u]; });
        if (is_due) vote(lattice, static_cast<std::uint32_t>(t));
    });
    pool_.parallel_for(count, [&](std::size_t first, std::size_t last) {
        std::fill_n(renewed_.data() + first, last - first, std::uint8_t{0});
    });
}

// Finds a triangle's pixels. Returns false if they have not changed, as for most triangles at silhouettes,
// which move by little; otherwise clears the ids of the pixels it had before.
bool TriangleLabeler::rasterize(const SplitLattice& lattice, std::uint32_t t, ThreadWork& work) {
    const Triangle& v = lattice.triangles[t];
    const std::span<const PixelRun> runs = find_runs(view_.width, view_.height, lattice.points[v[0]],
                                                     lattice.points[v[1]], lattice.points[v[2]], work.buffer);
    const std::span<const PixelRun> old = rows(t);
    if (lattice.changed[t] == step::kMoved && areas_[t] > 0 && std::ranges::equal(old, runs)) return false;
    for (const PixelRun& run : old)
        for (std::size_t i = view_.index(run.first, run.y), end = i + (run.end - run.first); i < end; ++i)
            if (step::belongs(load(triangle_ids_[i]), t)) store(triangle_ids_[i], 0);
    Rows& own = rows_[t];
    own.count = static_cast<std::uint32_t>(runs.size());
    if (own.count > own.capacity) {
        own.runs = work.runs.allocate(own.count);
        own.capacity = own.count;
    }
    std::ranges::copy(runs, own.runs);
    work.triangles.push_back(t);
    return true;
}

// Sets a triangle's area, first pixel and the flags plain, whole and trusted from the flags of its pixels.
void TriangleLabeler::scan_pixels(std::uint32_t t) {
    std::uint32_t area = 0, first = kNone;
    // The flags in any pixel, in all pixels, and in any pixel with another one of the triangle on its right.
    std::uint64_t any = 0, all = in_each_of_eight(step::kTrusted), inner = 0;
    // The last run with pixels, and the flags in any of its pixels.
    const PixelRun* upper = nullptr;
    std::uint64_t upper_flags = 0;
    // True while each row has a column in common with the row above, and while each row is connected with the
    // row above without a discontinuity somewhere.
    bool is_stacked = true, is_connected = true;
    for (const PixelRun& run : rows(t)) {
        if (run.first == run.end) continue;
        const std::uint8_t* const flags = view_.flags + view_.index(0, run.y);
        std::uint64_t row_flags = 0;
        for (int x = run.first; x < run.end; x += 8) {
            const std::uint64_t eight = eight_flags(flags + x), own = first_of_eight(run.end - x);
            row_flags |= eight & own;
            all &= eight | ~own;
            inner |= eight & (run.end - x > 8 ? own : own >> 8);
        }
        if (!upper) {
            first = static_cast<std::uint32_t>(view_.index(run.first, run.y));
        } else {
            is_stacked &= step::lie_above(*upper, run);
            is_connected =
                is_connected && is_stacked &&
                (!(upper_flags & in_each_of_eight(step::kDiscontinuityDown)) || is_linked(*upper, run));
        }
        any |= row_flags;
        upper = &run;
        upper_flags = row_flags;
        area += static_cast<std::uint32_t>(run.end - run.first);
    }
    areas_[t] = area;
    label_pixels_[t] = first;
    plain_[t] = is_stacked && !(any & kCracksOfEight);
    whole_[t] = is_connected && !(inner & in_each_of_eight(step::kDiscontinuityRight));
    trusted_[t] = all == in_each_of_eight(step::kTrusted);
}

// True if at some column no discontinuity separates two rows of a triangle; `lower` is in the next row.
bool TriangleLabeler::is_linked(const PixelRun& upper, const PixelRun& lower) const {
    const std::uint8_t* const flags = view_.flags + view_.index(0, upper.y);
    const int end = std::min(upper.end, lower.end);
    std::uint64_t free = 0;
    for (int x = std::max(upper.first, lower.first); x < end; x += 8)
        free |= ~eight_flags(flags + x) & first_of_eight(end - x);
    return (free & in_each_of_eight(step::kDiscontinuityDown)) != 0;
}

// Labels a triangle with the surface of its largest connected component, or without pixels with the
// surface at its centre.
void TriangleLabeler::label(const SplitLattice& lattice, std::uint32_t t, ThreadWork& work) {
    scan_pixels(t);
    renewed_[t] = 1;
    labels_.straddling[t] = 0;
    if (!whole_[t]) {
        TriangleComponents& components = work.components;
        const TriangleComponents::Largest largest = components.find(rows(t));
        label_pixels_[t] = largest.pixel;
        for (const TriangleComponents::Segment& s : components.segments())
            work.labelled.push_back({s.first, s.end, step::triangle_id(t, s.component == largest.segment)});
        labels_.straddling[t] = areas_[t] - largest.area >= step::kStraddling_px &&
                                outlier_error(components, largest) > step::kStraddlingError_px2 * cell_px_;
    }
    const Triangle& v = lattice.triangles[t];
    labels_.anchors[t] =
        label_pixels_[t] == kNone
            ? step::middle_pixel(view_, lattice.points[v[0]], lattice.points[v[1]], lattice.points[v[2]])
            : label_pixels_[t];
    labels_.kept[t] = view_.disparity[labels_.anchors[t]] > 0;
}

// Writes a triangle's ids. If the triangle is not whole, they are those of its labelled runs from `next` on.
void TriangleLabeler::write_ids(std::uint32_t t, const std::vector<LabelledRun>& labelled,
                                std::size_t& next) {
    if (whole_[t]) {
        for (const PixelRun& run : rows(t))
            write_id(triangle_ids_.data() + view_.index(run.first, run.y),
                     static_cast<std::size_t>(run.end - run.first), step::triangle_id(t, true));
    } else {
        for (; next < labelled.size() && step::belongs(labelled[next].id, t); ++next)
            write_id(triangle_ids_.data() + labelled[next].first, labelled[next].end - labelled[next].first,
                     labelled[next].id);
    }
}

// True if another thread wrote a lower id to one of the triangle's pixels in a race. To be called when
// all ids are written.
bool TriangleLabeler::is_overwritten(std::uint32_t t) const {
    const std::uint32_t least = step::triangle_id(t, false);
    for (const PixelRun& run : rows(t))
        for (std::size_t i = view_.index(run.first, run.y), end = i + (run.end - run.first); i < end; ++i)
            if (triangle_ids_[i] < least) return true;
    return false;
}

// Returns the error of the pixels of other components, if the mean of the label's pixels stood for them.
double TriangleLabeler::outlier_error(const TriangleComponents& components,
                                      const TriangleComponents::Largest& largest) const {
    double sum = 0, error = 0;
    for (const TriangleComponents::Segment& s : components.segments())
        for (std::uint32_t i = s.first; s.component == largest.segment && i < s.end; ++i)
            sum += view_.disparity[i];
    const double mean = sum / largest.area;
    for (const TriangleComponents::Segment& s : components.segments())
        for (std::uint32_t i = s.first; s.component != largest.segment && i < s.end; ++i)
            if (view_.flags[i] & step::kTrusted)
                error += step::outlier_error(view_.disparity[i], mean, nearest_px_);
    return error;
}

// True if all edges of which the triangle is the lower one are closed without a vote, see the step.
bool TriangleLabeler::is_closed_without_vote(const SplitLattice& lattice, std::uint32_t t) const {
    if (!is_plain(t)) return false;
    bool plain[3], each_is_closed = true;
    for (int k = 0; k < 3; ++k) {
        const std::int32_t n = lattice.neighbours[t][k];
        plain[k] = n < 0 || is_plain(static_cast<std::uint32_t>(n));
        if (n > static_cast<std::int32_t>(t))
            each_is_closed &= plain[k] && !step::may_differ(view_, labels_.anchors[t], labels_.anchors[n],
                                                            discontinuity_px_);
    }
    return each_is_closed || step::is_closed_without_vote(true, plain);
}

void TriangleLabeler::vote(const SplitLattice& lattice, std::uint32_t t) {
    if (is_closed_without_vote(lattice, t)) {
        labels_.open[t] = {};
        return;
    }
    const step::EdgeVotes votes = count_votes(lattice, t);
    for (int k = 0; k < 3; ++k) {
        const std::int32_t n = lattice.neighbours[t][k];
        if (n < static_cast<std::int32_t>(t)) continue;
        labels_.open[t][k] =
            votes.counts[k] > 0 ? votes.open(k) > votes.closed(k) : differ(t, static_cast<std::uint32_t>(n));
    }
}

// Counts the votes of all pairs of a pixel in the triangle's rows and a pixel next to it outside them.
step::EdgeVotes TriangleLabeler::count_votes(const SplitLattice& lattice, std::uint32_t t) const {
    step::EdgeVotes votes;
    const step::VoterIds voters = step::voters_of(t, lattice.neighbours[t]);
    const std::ptrdiff_t width = view_.width;
    const std::uint32_t* const ids = triangle_ids_.data();
    const std::uint8_t* const flags = view_.flags;
    // Adds the pairs of columns from .. to - 1 of a row with the pixels `by` further on in the map, one row
    // above or below. The flags of the upper row say whether a discontinuity lies between them.
    const auto add_columns = [&](std::ptrdiff_t row, int from, int to, std::ptrdiff_t by) {
        const std::uint32_t *const own = ids + row, *const other = own + by;
        const std::uint8_t* const upper = flags + row + std::min<std::ptrdiff_t>(by, 0);
        for (int x = from; x < to; ++x)
            step::add_vote(votes, voters, own[x], other[x], (upper[x] & step::kDiscontinuityDown) != 0);
    };
    // Adds the pairs of a run with the row above or below it, except those within the
    // triangle's run `beside` there.
    const auto add_row = [&](const PixelRun& run, const PixelRun& beside, std::ptrdiff_t by) {
        const int first = std::clamp(beside.first, run.first, run.end),
                  end = std::clamp(beside.end, first, run.end);
        const std::ptrdiff_t row = run.y * width;
        add_columns(row, run.first, first, by);
        add_columns(row, end, run.end, by);
    };
    // Adds the pair of a run's first or last pixel and the pixel outside the run next to it.
    const auto add_beside = [&](std::size_t left, bool own_is_left) {
        step::add_vote(votes, voters, ids[own_is_left ? left : left + 1], ids[own_is_left ? left + 1 : left],
                       (flags[left] & step::kDiscontinuityRight) != 0);
    };
    const std::span<const PixelRun> runs = rows(t);
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const PixelRun& run = runs[r];
        if (run.first == run.end) continue;
        if (run.first > 0) add_beside(view_.index(run.first - 1, run.y), false);
        if (run.end < view_.width) add_beside(view_.index(run.end - 1, run.y), true);
        if (run.y > 0) add_row(run, r > 0 ? runs[r - 1] : PixelRun{}, -width);
        if (run.y + 1 < view_.height) add_row(run, r + 1 < runs.size() ? runs[r + 1] : PixelRun{}, width);
    }
    return votes;
}

// Decides about an edge without pairs: true if a discontinuity lies between the triangles' anchors.
bool TriangleLabeler::differ(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t i = labels_.anchors[a], j = labels_.anchors[b];
    return step::may_differ(view_, i, j, discontinuity_px_) &&
           has_discontinuity(view_, step::way_between_pixels(view_, i, j));
}

void TriangleLabeler::collect_pixels(const SplitLattice& lattice) {
    labels_.fitted.resize(lattice.triangles.size());
    pool_.run([&](int thread) {
        ThreadWork& work = work_[static_cast<std::size_t>(thread)];
        for (std::size_t i = pool_.share(rows_.size(), thread), end = pool_.share(rows_.size(), thread + 1);
             i < end; ++i) {
            const std::uint32_t t = static_cast<std::uint32_t>(i);
            labels_.fitted[t] = !labels_.kept[t]           ? std::span<const PixelRun>()
                                : plain_[t] && trusted_[t] ? rows(t)
                                                           : fitted_rows(t, work);
        }
    });
}

// Returns the parts of a triangle's rows that lie on its label and are not speckles.
std::span<const PixelRun> TriangleLabeler::fitted_rows(std::uint32_t t, ThreadWork& work) {
    work.buffer.clear();
    for (const PixelRun& run : rows(t)) {
        const std::size_t start = view_.index(0, run.y);
        const auto fitted = [&](int x) {
            return triangle_ids_[start + x] == step::triangle_id(t, true) &&
                   (view_.flags[start + x] & step::kTrusted);
        };
        for (int x = run.first; x < run.end;) {
            const int first = x;
            while (x < run.end && fitted(x)) ++x;
            if (first < x)
                work.buffer.push_back({run.y, first, x});
            else
                ++x;
        }
    }
    PixelRun* const runs = work.runs.allocate(work.buffer.size());
    std::ranges::copy(work.buffer, runs);
    return {runs, work.buffer.size()};
}

}  // namespace hexrelief::surface
