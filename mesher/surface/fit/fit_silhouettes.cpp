#include "mesher/surface/fit/fit_silhouettes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>

#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/fit/inset_silhouettes_step.h"
#include "mesher/surface/pixels/eight_flags.h"
#include "mesher/surface/topology/triangle_shape_step.h"
#include "pipeline/base/simd.h"
#include "pipeline/base/thread_team.h"

namespace hexrelief::surface {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

// True if a vertex has moved so far that the crack edges around it must be searched again.
bool has_left(const Vec2f& from, const Vec2f& p) {
    const float dx = p.x - from.x, dy = p.y - from.y;
    return dx * dx + dy * dy > step::kSilhouetteStay_px * step::kSilhouetteStay_px;
}

// Writes share, residual, weight and across of all samples, one array after the other.
HEXRELIEF_VECTORS void find_residuals(const step::SilhouetteEdgeFrame& edge, const float* __restrict samples,
                                      int count, float* __restrict residuals) {
    const step::SilhouetteEdgeFrame e = edge;
    for (int first = 0; first < count; first += kSamplesAtOnce)
        for (int i = first; i < first + kSamplesAtOnce; ++i) {
            const step::SilhouetteResidual residual = step::silhouette_residual(
                e, {samples[i], samples[count + i], samples[2 * count + i], samples[3 * count + i]});
            residuals[i] = residual.share;
            residuals[count + i] = residual.residual;
            residuals[2 * count + i] = residual.weight;
            residuals[3 * count + i] = residual.across;
        }
}

}  // namespace

SilhouetteFitter::SilhouetteFitter(const PixelSurfaces& surfaces, ThreadPool& pool)
    : view_(surfaces.view()), pool_(pool) {
    for (int thread = 0; thread < pool.size(); ++thread)
        work_.push_back({SilhouetteSampler(view_), {}, 0, {}});
}

// One thread's view of loops that all threads run one after the other.
class SilhouetteFitter::ThreadLoops {
  public:
    ThreadLoops(ThreadPool& pool, std::vector<ThreadPool::ChunkCounters>& counters, int own_thread)
        : thread(own_thread), pool_(pool), counters_(counters) {}
    const int thread;

    template <typename Visit>
    void each(std::size_t count, const Visit& visit) {
        pool_.run_chunks(count, thread, counters_[loop_++], [&](std::size_t i) { visit(i); });
    }

  private:
    ThreadPool& pool_;
    std::vector<ThreadPool::ChunkCounters>& counters_;
    std::size_t loop_ = 0;
};

void SilhouetteFitter::fit(const TriangleLabels& labels, SplitLattice& lattice) {
    constexpr std::size_t kLoops = 4 * step::kSilhouetteRounds + 2;
    gather_edges(labels, lattice);
    number_vertices(lattice);
    moved_.assign(vertices_.size(), 1);
    marked_.assign(vertices_.size(), 0);
    held_.assign(vertices_.size(), 0);
    std::vector<ThreadPool::ChunkCounters> counters(kLoops, ThreadPool::ChunkCounters(pool_.size()));
    pool_.run([&](int thread) {
        ThreadLoops loops(pool_, counters, thread);
        find_triangles(lattice, thread);
        loops.each(edges_.size(),
                   [&](std::size_t e) { slots_[edges_[e].slot] = static_cast<std::uint32_t>(e); });
        pool_.barrier();
        if (thread == 0) find_ends();
        if (thread == pool_.size() - 1) {
            triangles_.clear();
            for (const ThreadWork& work : work_)
                triangles_.insert(triangles_.end(), work.triangles.begin(), work.triangles.end());
        }
        for (int round = 0; round < step::kSilhouetteRounds; ++round) move_vertices(lattice, loops);
        loops.each(triangles_.size(), [&](std::size_t i) { mark_moved(lattice, triangles_[i].number); });
    });
}

// Gathers the edges of all threads in the order of triangles; the vertices' targets start at their positions.
void SilhouetteFitter::gather_edges(const TriangleLabels& labels, const SplitLattice& lattice) {
    edges_.swap(before_);
    slots_.reserve(3 * lattice.triangles.capacity());
    slots_.resize(3 * lattice.triangles.size(), 0);
    pool_.run([&](int thread) { find_edges(labels, lattice, thread); });
    std::size_t all = 0;
    for (ThreadWork& work : work_) {
        work.first = all;
        all += work.edges.size();
    }
    edges_.resize(all);
    targets_.resize(lattice.points.size());
    pool_.run([&](int thread) {
        const ThreadWork& work = work_[thread];
        std::ranges::copy(work.edges, edges_.begin() + static_cast<std::ptrdiff_t>(work.first));
        const std::size_t first = pool_.share(targets_.size(), thread),
                          end = pool_.share(targets_.size(), thread + 1);
        std::copy_n(lattice.points.data() + first, end - first, targets_.data() + first);
    });
}

// Makes one round, on all threads.
void SilhouetteFitter::move_vertices(SplitLattice& lattice, ThreadLoops& loops) {
    std::vector<Vec2f>& points = lattice.points;
    loops.each(edges_.size(), [&](std::size_t e) {
        if (has_moved(edges_[e])) find_residuals(points, edges_[e], work_[loops.thread].sampler);
    });
    pool_.barrier();
    loops.each(vertices_.size(), [&](std::size_t i) {
        held_[i] = 0;
        if (!has_moved_around(i)) return;
        const std::uint32_t v = vertices_[i];
        targets_[v] = target(points[v], i);
        far2_[v] = std::max(far2_[v], step::squared_length(starts_[i], targets_[v]));
    });
    pool_.barrier();
    loops.each(triangles_.size(), [&](std::size_t i) {
        const SilhouetteTriangle& t = triangles_[i];
        const Triangle& n = lattice.triangles[t.number];
        if (std::max(far2_[n[0]], std::max(far2_[n[1]], far2_[n[2]])) > t.slack2) hold_corners(points, n);
    });
    pool_.barrier();
    loops.each(vertices_.size(), [&](std::size_t i) {
        const std::uint32_t v = vertices_[i];
        moved_[i] = !held_[i] && !(targets_[v] == points[v]);
        if (!moved_[i]) return;
        points[v] = targets_[v];
        marked_[i] = 1;
    });
    pool_.barrier();
}

// Marks a triangle in the lattice as moved if one of its corners has moved.
void SilhouetteFitter::mark_moved(SplitLattice& lattice, std::uint32_t t) const {
    std::uint8_t& changed = lattice.changed[t];
    const auto is_marked = [&](std::uint32_t v) { return index_[v] != kNone && marked_[index_[v]]; };
    const Triangle& n = lattice.triangles[t];
    if (changed == step::kSame && (is_marked(n[0]) || is_marked(n[1]) || is_marked(n[2])))
        changed = step::kMoved;
}

// True if one of the edges at the i-th silhouette vertex has moved.
bool SilhouetteFitter::has_moved_around(std::size_t i) const {
    const auto ends = ends_[i];
    return std::any_of(ends.begin(), ends.end(),
                       [&](std::uint32_t end) { return has_moved(edges_[end / 2]); });
}

// Finds the silhouette edges of a thread's share of triangles. It avoids unpredictable branches.
void SilhouetteFitter::find_edges(const TriangleLabels& labels, const SplitLattice& lattice, int thread) {
    std::vector<Edge>& found = work_[thread].edges;
    found.clear();
    const std::size_t count = lattice.triangles.size();
    const std::int32_t end = static_cast<std::int32_t>(pool_.share(count, thread + 1));
    for (std::int32_t t = static_cast<std::int32_t>(pool_.share(count, thread)); t < end; ++t)
        for (int k = 0; k < 3; ++k) {
            const std::int32_t n = lattice.neighbours[t][k];
            const bool once = n >= t;  // true for one of an edge's two triangles; false at the image's border
            if (!(once & step::is_silhouette(labels.kept[t] != 0, labels.kept[once ? n : t] != 0,
                                             labels.open[t][k] != 0)))
                continue;
            const std::uint32_t slot = 3 * static_cast<std::uint32_t>(t) + static_cast<std::uint32_t>(k),
                                a = lattice.triangles[t][k], b = lattice.triangles[t][(k + 1) % 3];
            if (slots_[slot] < before_.size())
                if (const Edge& old = before_[slots_[slot]]; old.slot == slot && old.a == a && old.b == b) {
                    found.push_back(old);
                    continue;
                }
            found.push_back({.a = a, .b = b, .slot = slot});
        }
}

// Numbers the silhouettes' vertices in the order of the edges.
void SilhouetteFitter::number_vertices(const SplitLattice& lattice) {
    for (const std::uint32_t v : vertices_) index_[v] = kNone, far2_[v] = 0;
    index_.resize(lattice.points.size(), kNone);
    far2_.resize(lattice.points.size(), 0);
    vertices_.clear();
    starts_.clear();
    for (const Edge& edge : edges_)
        for (const std::uint32_t v : {edge.a, edge.b}) {
            if (index_[v] != kNone) continue;
            index_[v] = static_cast<std::uint32_t>(vertices_.size());
            vertices_.push_back(v);
            starts_.push_back(lattice.points[v]);
        }
}

// Finds the triangles of a thread's share with three silhouette vertices.
void SilhouetteFitter::find_triangles(const SplitLattice& lattice, int thread) {
    std::vector<SilhouetteTriangle>& found = work_[thread].triangles;
    found.clear();
    const std::size_t count = lattice.triangles.size();
    for (std::size_t t = pool_.share(count, thread), end = pool_.share(count, thread + 1); t < end; ++t) {
        const Triangle& n = lattice.triangles[t];
        if ((index_[n[0]] & index_[n[1]] & index_[n[2]]) != kNone)
            found.push_back({static_cast<std::uint32_t>(t),
                             step::corner_slack2(lattice.points[n[0]], lattice.points[n[1]],
                                                 lattice.points[n[2]], step::kSilhouetteLeastShape)});
    }
}

// Lists the edges that end at each silhouette vertex.
void SilhouetteFitter::find_ends() {
    ends_ = sort_into(vertices_.size(), [&](const auto& put) {
        for (std::uint32_t e = 0; e < edges_.size(); ++e)
            put(index_[edges_[e].a], 2 * e), put(index_[edges_[e].b], 2 * e + 1);
    });
}

// Sums up the edge's residuals, unless its vertices have not moved since the last time.
void SilhouetteFitter::find_residuals(const std::vector<Vec2f>& points, Edge& edge,
                                      SilhouetteSampler& sampler) const {
    const Vec2f &p = points[edge.a], &q = points[edge.b];
    if (edge.seen && edge.at_a == p && edge.at_b == q) return;
    if (!edge.seen || has_left(edge.from_a, p) || has_left(edge.from_b, q)) {
        // the search range allows for the distance that the vertices may move before the next search
        edge.samples = sampler.find(p, q, step::kSilhouetteFitReach_px + step::kSilhouetteStay_px);
        edge.from_a = p;
        edge.from_b = q;
    }
    edge.seen = true;
    edge.at_a = p;
    edge.at_b = q;
    edge.residuals = {};
    const step::SilhouetteEdgeFrame frame = step::silhouette_edge_frame(p, q);
    if (!(frame.size2 > 0)) return;
    edge.nx = frame.nx;
    edge.ny = frame.ny;
    edge.residuals = sampler.residuals(frame, edge.samples);
}

// Returns the target of the i-th silhouette vertex, at `from`, by the residuals of the edges at it.
Vec2f SilhouetteFitter::target(const Vec2f& from, std::size_t i) const {
    step::SilhouetteEquation e;
    for (const std::uint32_t end : ends_[i]) {
        const Edge& edge = edges_[end / 2];
        step::add_edge(e, edge.nx, edge.ny, edge.residuals.weights[end % 2],
                       edge.residuals.residuals[end % 2]);
    }
    return step::silhouette_target(e, from, static_cast<float>(view_.width),
                                   static_cast<float>(view_.height));
}

// Holds back the corners whose moves would make the triangle thin. Several threads may hold the same vertex.
void SilhouetteFitter::hold_corners(const std::vector<Vec2f>& points, const Triangle& n) {
    const Vec2f from[3] = {points[n[0]], points[n[1]], points[n[2]]};
    const Vec2f to[3] = {targets_[n[0]], targets_[n[1]], targets_[n[2]]};
    unsigned moving = 0;
    for (int k = 0; k < 3; ++k)
        moving |= static_cast<unsigned>((from[k].x != to[k].x) | (from[k].y != to[k].y)) << k;
    if (moving == 0) return;
    const unsigned held = moving & ~step::free_corners(from, to, step::kSilhouetteLeastShape);
    for (int k = 0; k < 3; ++k)
        if (held >> k & 1u) std::atomic_ref(held_[index_[n[k]]]).store(1, std::memory_order_relaxed);
}

SilhouetteSamples SilhouetteSampler::find(const Vec2f& p, const Vec2f& q, float reach_px) {
    const step::PixelBox box = step::pixels_around(view_, p, q, reach_px);
    const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
    const float around = reach_px + step::kRounding_px;
    const float most = around * around * size2;
    // along the edge, multiplied by its length
    const float before = -around * std::sqrt(size2), beyond = size2 - before;
    buffer_.clear();
    for (int y = box.y0; y <= box.y1; ++y)
        each_crack(view_, y, box.x0, box.x1 + 1, [&](const step::Crack& c) {
            const step::SilhouetteSample sample = step::silhouette_sample(view_, c);
            const float mx = sample.x - p.x, my = sample.y - p.y;
            const float off = my * dx - mx * dy, along = mx * dx + my * dy;
            if (off * off <= most && along >= before && along <= beyond) buffer_.push_back(sample);
        });
    const std::size_t count = (buffer_.size() + kSamplesAtOnce - 1) / kSamplesAtOnce * kSamplesAtOnce;
    buffer_.resize(count, {0, 0, 0, 0});
    float* const values = found_.allocate(4 * count);
    for (std::size_t i = 0; i < count; ++i) {
        values[i] = buffer_[i].x;
        values[count + i] = buffer_[i].y;
        values[2 * count + i] = buffer_[i].near_x;
        values[3 * count + i] = buffer_[i].near_y;
    }
    return {values, static_cast<int>(count)};
}

step::SilhouetteResiduals SilhouetteSampler::residuals(const step::SilhouetteEdgeFrame& edge,
                                                       const SilhouetteSamples& samples) {
    const std::size_t size = static_cast<std::size_t>(samples.count);
    if (weighing_.size() < size) {
        weighing_.resize(2 * size);
        residuals_.resize(8 * size);
    }
    find_residuals(edge, samples.values, samples.count, residuals_.data());
    const float *const shares = residuals_.data(), *const residuals = shares + size,
                       *const weights = residuals + size, *const acrosses = weights + size;
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < size; ++i) {  // without a branch, which would be unpredictable
        weighing_[count] = i;
        count += weights[i] != 0;
    }
    double facing = 0;
    const std::span<const std::uint32_t> weighing(weighing_.data(), count);
    for (const std::uint32_t i : weighing) facing += weights[i] * acrosses[i];
    step::SilhouetteResiduals sums{};
    for (const std::uint32_t i : weighing)
        step::add_residual(sums, {shares[i], residuals[i], weights[i], acrosses[i]}, facing);
    return sums;
}

void inset_silhouettes(const PixelSurfaces& surfaces, const DisparityMap& map, double by_px,
                       const LatticeFans& fans, CutTriangles& cut, ThreadPool& pool) {
    const std::size_t points = cut.points.size();
    RawVector<unsigned> starts(points), ends(points);
    RawVector<std::uint32_t> corners(3 * cut.triangles.size());
    RawVector<Vec2f> targets(points);
    RawVector<std::uint8_t> moves(points);
    const step::InsetArrays arrays{
        {starts.data(), ends.data(), corners.data()}, targets.data(), moves.data()};
    ThreadTeam::run(pool, [&](ThreadTeam& team) {
        step::inset_silhouettes(team, surfaces.view(), map.values.data(), by_px, fans, cut.view(),
                                cut.points.data(), arrays);
    });
}

}  // namespace hexrelief::surface
