// Disparities of the sheet's vertices, as mesher/vertex_fit.cpp finds them.
#pragma once

#include "cuda/sheet_crew.cuh"
#include "cuda/sheet_state.cuh"
#include "cuda/triangle_sums.cuh"
#include "mesher/steps/vertex_fit.h"

namespace hexrelief::cuda {

struct FitArrays {
    // Corners of a vertex with an own place for their terms, so that neighbouring threads read neighbouring
    // ones; those beyond are looked up anew.
    static constexpr unsigned kSlots = 8;

    DeviceBuckets corners;                // of each vertex: 3 * triangle + corner
    step::Moments* moments;               // of triangles; after the start
    step::TriangleSums* sums;             // their memory holds these
    step::WeightSlack* slacks;            // of triangles
    double *values, *relaxed;             // disparities of vertices,
    double *planes, *weighed;             // at first, and when the triangles were last weighed
    double* diagonals;                    // of vertices
    float *least, *most;                  // bounds of vertices
    unsigned* known;                      // vertices: 0 = no pixel is near
    double *next_row, *last_row, *right;  // slot * stride + vertex
    unsigned *next, *last;                // the triangle's other vertices
    unsigned stride;
};

template <typename Take>
FitArrays take_fit_arrays(const SheetSizes& sizes, const Take& take) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles,
                      slots = FitArrays::kSlots * points;
    FitArrays a{};
    a.corners = {take.template operator()<unsigned>(points + 1), take.template operator()<unsigned>(points),
                 take.template operator()<unsigned>(3 * triangles)};
    a.moments = take.template operator()<step::Moments>(triangles);
    a.sums = reinterpret_cast<step::TriangleSums*>(a.moments);
    a.slacks = take.template operator()<step::WeightSlack>(triangles);
    for (double** each : {&a.values, &a.relaxed, &a.planes, &a.weighed, &a.diagonals})
        *each = take.template operator()<double>(points);
    for (float** each : {&a.least, &a.most}) *each = take.template operator()<float>(points);
    a.known = take.template operator()<unsigned>(points);
    for (double** each : {&a.next_row, &a.last_row, &a.right})
        *each = take.template operator()<double>(slots);
    for (unsigned** each : {&a.next, &a.last}) *each = take.template operator()<unsigned>(slots);
    a.stride = sizes.most_points;
    return a;
}
static_assert(sizeof(step::TriangleSums) <= sizeof(step::Moments));

// Of each triangle's pixels.
template <typename Crew>
__device__ void find_moments(const Crew& crew, const SheetState& s, const FitArrays& a, unsigned count,
                             PixelSums& sums) {
    const step::PixelView view = s.view();
    each_chosen_triangle(
        crew, s, count, [](unsigned) { return true; },
        [&](unsigned t, const PixelRun* runs, unsigned run_count) {
            step::Moments range;  // of the lane's pixels
            each_32_pixels(runs, run_count, [&](int x, int y, bool is_one, unsigned lanes) {
                step::Moments m;
                if (is_one) {
                    const float d = view.disparity[view.index(x, y)];
                    step::add_run(m, y, x, x + 1);
                    step::add_disparity(m, x, y, d);
                    range.least = step::min_of(range.least, d);
                    range.most = step::max_of(range.most, d);
                }
                sums.add({m.n, m.x, m.y, m.xx, m.xy, m.yy, m.d, m.xd, m.yd}, lanes);
            });
            for (int step = 16; step > 0; step /= 2) {
                range.least = step::min_of(range.least, __shfl_xor_sync(~0u, range.least, step));
                range.most = step::max_of(range.most, __shfl_xor_sync(~0u, range.most, step));
            }
            const double sum = sums.take();
            if (crew.lane() < PixelSums::kSums) (&a.moments[t].n)[crew.lane()] = sum;
            if (crew.lane() == PixelSums::kSums) a.moments[t].least = range.least;
            if (crew.lane() == PixelSums::kSums + 1) a.moments[t].most = range.most;
        });
}

// Over the triangles at the vertices of the triangles at v, by a warp; the same in all lanes.
__device__ inline step::Moments moments_around(const SheetState& s, const FitArrays& a, unsigned v) {
    constexpr unsigned kAtOnce = 10;  // corners; their 30 vertices are looked up side by side
    const unsigned lane = threadIdx.x % 32, k = lane < PixelSums::kSums ? lane : 0;
    step::Moments m;
    double sum = 0;
    const unsigned end = a.corners.starts[v + 1];
    for (unsigned i = a.corners.starts[v]; i < end; i += kAtOnce) {
        const unsigned vertices = 3 * min(kAtOnce, end - i);
        unsigned start = 0, count = 0;
        if (lane < vertices) {
            const unsigned u = s.sheet.triangles[a.corners.items[i + lane / 3] / 3][lane % 3];
            start = a.corners.starts[u];
            count = a.corners.count(u);
        }
        for (unsigned j = 0; j < vertices; ++j) {
            const unsigned first = __shfl_sync(~0u, start, j), all = __shfl_sync(~0u, count, j);
            for (unsigned c = 0; c < all; c += 32) {
                const unsigned some = min(32u, all - c),
                               t = lane < some ? a.corners.items[first + c + lane] / 3 : 0;
                if (lane < some) {
                    m.least = step::min_of(m.least, a.moments[t].least);
                    m.most = step::max_of(m.most, a.moments[t].most);
                }
                for (unsigned q = 0; q < some; q += 4) {
                    double more[4];
#pragma unroll
                    for (unsigned e = 0; e < 4; ++e) {
                        const unsigned from = __shfl_sync(~0u, t, (q + e) % 32);
                        more[e] = q + e < some ? (&a.moments[from].n)[k] : 0.0;
                    }
#pragma unroll
                    for (unsigned e = 0; e < 4; ++e) sum += more[e];
                }
            }
        }
    }
#pragma unroll
    for (int n = 0; n < PixelSums::kSums; ++n) (&m.n)[n] = __shfl_sync(~0u, sum, n);
    for (int step = 16; step > 0; step /= 2) {
        m.least = step::min_of(m.least, __shfl_xor_sync(~0u, m.least, step));
        m.most = step::max_of(m.most, __shfl_xor_sync(~0u, m.most, step));
    }
    return m;
}

// Each vertex at the plane through the pixels around it; returns whether one of the thread's has none.
template <typename Crew>
__device__ bool start_from_planes(const Crew& crew, const SheetState& s, const FitArrays& a,
                                  unsigned points) {
    const double floor = step::lowest_disparity(s.totals->farthest_px);
    bool any_unknown = false;
    for (unsigned base = 32 * scattered_warp(crew); base < points; base += crew.threads()) {
        const unsigned v = base + crew.lane();
        step::Moments sum;
        float longest = 0;
        bool holds = true;
        if (v < points) {
            const Vec2f at = s.sheet.points[v];
            for (unsigned i = a.corners.starts[v]; i < a.corners.starts[v + 1]; ++i) {
                const unsigned t = a.corners.items[i] / 3;
                step::add_moments(sum, a.moments[t]);
                for (const unsigned u : s.sheet.triangles[t])
                    longest = step::max_of(longest, step::squared_length(at, s.sheet.points[u]));
            }
            holds = step::holds_plane(sum);
        }
        for (unsigned left = __ballot_sync(~0u, !holds); left != 0; left &= left - 1) {
            const unsigned from = static_cast<unsigned>(__ffs(static_cast<int>(left))) - 1;
            const step::Moments around = moments_around(s, a, base + from);
            if (crew.lane() == from) sum = around;
        }
        if (v >= points) continue;
        a.known[v] = sum.n > 0;
        if (sum.n > 0) {
            const step::FitStart start = step::fit_start(sum, s.sheet.points[v], sqrtf(longest), floor);
            a.least[v] = start.least;
            a.most[v] = start.most;
            a.values[v] = a.planes[v] = start.disparity;
        } else {
            any_unknown = true;
        }
    }
    return any_unknown;
}

// known[v]: the ring in which v became known, from 1 on.
template <typename Crew>
__device__ void fill_unknown(Crew& crew, const SheetState& s, const FitArrays& a, unsigned points) {
    const auto set = [&](unsigned v, double value) {
        a.values[v] = a.planes[v] = value;
        a.least[v] = a.most[v] = static_cast<float>(value);
    };
    const auto look = [&](unsigned v) { return *const_cast<volatile unsigned*>(&a.known[v]); };
    for (unsigned ring = 1;; ++ring) {
        bool moved = false;
        for (unsigned v = crew.thread(); v < points; v += crew.threads()) {
            if (look(v) != 0) continue;
            double sum = 0;
            int count = 0;
            for (unsigned i = a.corners.starts[v]; i < a.corners.starts[v + 1]; ++i)
                for (const unsigned u : s.sheet.triangles[a.corners.items[i] / 3]) {
                    const unsigned known = look(u);
                    if (known != 0 && known <= ring) sum += a.values[u], ++count;
                }
            if (count == 0) continue;
            set(v, sum / count);
            *const_cast<volatile unsigned*>(&a.known[v]) = ring + 1;
            moved = true;
        }
        if (!crew.any(moved)) break;
    }
    const double floor = step::lowest_disparity(s.totals->farthest_px);
    crew.each(points, [&](unsigned v) {
        if (a.known[v] != 0) return;
        const unsigned t = a.corners.items[a.corners.starts[v]] / 3;
        set(v, step::max_of(floor,
                            static_cast<double>(s.view().disparity[s.sides.anchors[s.sheet.origins[t]]])));
    });
}

// The normal equations with the present residuals' weights, where these may have changed.
template <typename Crew>
__device__ void gather_sums(const Crew& crew, const SheetState& s, const FitArrays& a, unsigned count,
                            bool first_round, PixelSums& sums) {
    const step::PixelView view = s.view();
    const auto chosen = [&](unsigned t) {
        if (first_round) return true;
        double change = 0, largest = 0;
        for (const unsigned u : s.sheet.triangles[t]) {
            const double value = a.values[u];
            change = step::max_of(change, step::size_of(value - a.weighed[u]));
            largest = step::max_of(largest, step::size_of(value));
        }
        step::WeightSlack slack = a.slacks[t];
        step::use_up(slack, change, largest);
        if (!(slack.px > 0)) return true;
        a.slacks[t] = slack;
        return false;
    };
    each_chosen_triangle(crew, s, count, chosen, [&](unsigned t, const PixelRun* runs, unsigned run_count) {
        const Triangle v = s.sheet.triangles[t];
        const Vec2f pa = s.sheet.points[v[0]], pb = s.sheet.points[v[1]], pc = s.sheet.points[v[2]];
        const step::PlanePatch patch = step::plane_patch(pa.x, pa.y, pb.x, pb.y, pc.x, pc.y, a.values[v[0]],
                                                         a.values[v[1]], a.values[v[2]]);
        double most = 0, share = 1;  // of the lane's pixels
        each_32_pixels(runs, run_count, [&](int x, int y, bool is_one, unsigned lanes) {
            step::TriangleSums own;
            if (is_one) {
                const double d = view.disparity[view.index(x, y)];
                double l1, l2;
                const double residual = step::pixel_residual(patch, x, y, d, l1, l2), l0 = 1 - l1 - l2;
                step::add_pixel(own, l0, l1, l2, d, step::huber_weight(residual, step::kFitTolerance_px));
                most = step::max_of(most, step::size_of(residual));
                share = step::max_of(share, step::size_of(l0) + step::size_of(l1) + step::size_of(l2));
            }
            sums.add({own.a00, own.a11, own.a22, own.a01, own.a02, own.a12, own.b0, own.b1, own.b2}, lanes);
        });
        for (int step = 16; step > 0; step /= 2) {
            most = step::max_of(most, __shfl_xor_sync(~0u, most, step));
            share = step::max_of(share, __shfl_xor_sync(~0u, share, step));
        }
        const double sum = sums.take();
        if (crew.lane() < PixelSums::kSums) (&a.sums[t].a00)[crew.lane()] = sum;
        if (crew.lane() == PixelSums::kSums) a.slacks[t] = step::weight_slack(most, share);
    });
}

// A sweep from `values` to `out`; the first after the sums were gathered writes the terms that the next read.
template <typename Crew, typename Done>
__device__ void relax(const Crew& crew, const SheetState& s, const FitArrays& a, unsigned points,
                      bool is_first, const double* values, double* out, const Done& done) {
    for (unsigned base = 32 * scattered_warp(crew); base < points; base += crew.threads()) {
        const unsigned v = base + crew.lane();
        if (v >= points) continue;
        const unsigned start = a.corners.starts[v], count = a.corners.starts[v + 1] - start;
        const double value = values[v];
        double right = step::kFitPull * a.planes[v], diagonal = step::kFitPull;
        const unsigned known = is_first ? 0 : min(count, FitArrays::kSlots);
        for (unsigned j = 0; j < known; ++j) {
            const unsigned at = j * a.stride + v;
            right += step::right_side({0, a.next_row[at], a.last_row[at], a.right[at]}, values[a.next[at]],
                                      values[a.last[at]]);
        }
        for (unsigned j = known; j < count; ++j) {
            const unsigned item = a.corners.items[start + j], t = item / 3, k = item % 3;
            const step::CornerRow row = step::corner_row(a.sums[t], static_cast<int>(k));
            const unsigned next = s.sheet.triangles[t][(k + 1) % 3], last = s.sheet.triangles[t][(k + 2) % 3];
            right += step::right_side(row, values[next], values[last]);
            diagonal += row.own;
            if (!is_first || j >= FitArrays::kSlots) continue;
            const unsigned at = j * a.stride + v;
            a.next_row[at] = row.next;
            a.last_row[at] = row.last;
            a.right[at] = row.right;
            a.next[at] = next;
            a.last[at] = last;
        }
        if (is_first) {
            a.weighed[v] = value;
            a.diagonals[v] = diagonal;
        } else {
            diagonal = a.diagonals[v];
        }
        const double result = step::relaxed(value, right, diagonal, a.least[v], a.most[v]);
        out[v] = result;
        done(v, result);
    }
}

// Writes s.sheet.disparities. Reads the sheet's points, triangles and origins, pixels and their runs,
// anchors, and of the totals sheet_points, sheet_triangles and farthest_px.
template <typename Crew>
__device__ void fit_disparities(Crew& crew, const SheetState& s, const FitArrays& a) {
    __shared__ double scratch[PixelSums::kPixels][PixelSums::kSums];
    PixelSums sums(scratch);
    const unsigned points = s.totals->sheet_points, triangles = s.totals->sheet_triangles;
    find_moments(crew, s, a, triangles, sums);  // beside the corners, which do not need them
    sort_into(crew, a.corners, points, 3 * triangles,
              [&](unsigned i, const auto& put) { put(s.sheet.triangles[i / 3][i % 3], i); });
    if (crew.any(start_from_planes(crew, s, a, points))) fill_unknown(crew, s, a, points);
    for (int round = 0; round < step::kFitRounds; ++round) {
        gather_sums(crew, s, a, triangles, round == 0, sums);
        crew.wait();
        for (int sweep = 0; sweep < step::kFitSweeps; ++sweep) {
            const bool odd = sweep % 2 != 0,
                       last = round + 1 == step::kFitRounds && sweep + 1 == step::kFitSweeps;
            relax(crew, s, a, points, sweep == 0, odd ? a.relaxed : a.values, odd ? a.values : a.relaxed,
                  [&](unsigned v, double value) {
                      if (last) s.sheet.disparities[v] = static_cast<float>(value);
                  });
            crew.wait();
        }
    }
    static_assert(step::kFitSweeps % 2 == 0, "a round ends where it began");
}

}  // namespace hexrelief::cuda
