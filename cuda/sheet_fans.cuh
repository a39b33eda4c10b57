// The sheet's triangles, vertices and pixels, as SideFinder::collect_pixels and open_fans give them.
#pragma once

#include <cstdint>

#include "cuda/sheet_sides.cuh"
#include "mesher/steps/fans.h"

namespace hexrelief::cuda {

struct FanArrays {
    std::uint32_t* firsts;      // a corner: the first of its fan
    std::uint32_t* next;        // a first corner: another one at its vertex
    std::uint32_t* lists;       // a vertex: one of them, kNone = none
    std::uint32_t* fans;        // a vertex: how many
    std::uint32_t* numbers;     // a first corner: its new vertex
    std::uint32_t* runs;        // a triangle: how many
    std::uint32_t* places;      // a triangle: where it comes in the sheet, behind the new vertices
    std::uint32_t* run_places;  // a triangle: where its runs come, behind both
    unsigned* behind;           // two: how many new vertices; and triangles of the sheet
};

// Of all runs: as many as pixels, where triangles do not overlap.
__host__ __device__ inline unsigned run_room(const SheetSizes& sizes) {
    return sizes.pixels() + sizes.most_triangles;
}

template <typename Take>
FanArrays take_fan_arrays(const SheetSizes& sizes, const Take& take) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles;
    const auto words = [&](std::size_t count) { return take.template operator()<std::uint32_t>(count); };
    FanArrays a{};
    a.firsts = words(3 * triangles);
    a.next = words(3 * triangles);
    a.lists = words(points);
    a.fans = words(points);
    a.numbers = words(3 * triangles);
    a.runs = words(triangles);
    a.places = words(triangles);
    a.run_places = words(triangles);
    a.behind = words(2);
    return a;
}

class DeviceFans {
  public:
    __device__ DeviceFans(const SheetState& s, const SideArrays& sides, const FanArrays& a)
        : s_(s), sides_(sides), a_(a), view_(s.view()) {}

    // Fills the sheet's points, triangles, olds and origins, and the runs of all kept triangles.
    template <typename Crew>
    __device__ void open(Crew& crew) const {
        const unsigned points = s_.totals->points, triangles = s_.totals->triangles;
        crew.each(points, [&](unsigned v) {
            a_.lists[v] = kNone;
            a_.fans[v] = 0;
        });
        for (unsigned i = crew.thread(); i < 3 * triangles; i += crew.threads()) find_fan(i);
        each_wanted(
            crew, triangles,
            [&](unsigned t) {
                const bool kept = s_.sides.kept[t] != 0, simple = is_simple(t);
                a_.runs[t] = kept && simple ? sides_.row_counts[t] : 0;
                return kept && !simple;
            },
            [&](unsigned t) { count_runs(crew.lane(), t); });
        crew.wait();
        // all three numberings at once
        const unsigned all = crew.scan(
            points + 2 * triangles,
            [&](unsigned i) -> unsigned {
                if (i < points) return a_.fans[i];
                return i < points + triangles ? s_.sides.kept[i - points] : a_.runs[i - points - triangles];
            },
            [&](unsigned i, unsigned before) {
                if (i == points) a_.behind[0] = before;
                if (i == points + triangles) a_.behind[1] = before;
                if (i < points)
                    number_fans(i, before);
                else if (i < points + triangles)
                    a_.places[i - points] = before;
                else
                    a_.run_places[i - points - triangles] = before;
            });
        const unsigned fans = triangles ? a_.behind[0] : all, behind = triangles ? a_.behind[1] : all;
        for (unsigned t = crew.thread(); t < triangles; t += crew.threads()) {
            s_.sides.run_starts[t] = a_.run_places[t] - behind;
            if (s_.sides.kept[t]) put_triangle(t, a_.places[t] - fans);
        }
        const unsigned runs = all - behind, room = run_room(s_.sizes);
        if (crew.thread() == 0) {
            s_.sides.run_starts[triangles] = runs;
            s_.totals->sheet_points = fans;
            s_.totals->sheet_triangles = behind - fans;
            if (fans > s_.sizes.most_points) atomicMax(&s_.totals->too_many, fans - s_.sizes.most_points);
            if (runs > room) atomicMax(&s_.totals->too_many, runs - room);
        }
        if (runs <= room)
            each_wanted(
                crew, triangles, [&](unsigned t) { return s_.sides.kept[t] != 0; },
                [&](unsigned t) { put_runs(crew.lane(), t, s_.sides.runs + (a_.run_places[t] - behind)); });
        crew.wait();
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    // A simple triangle's runs are its rows with pixels.
    __device__ bool is_simple(unsigned t) const {
        constexpr std::uint8_t kBoth = SideArrays::kPlain | SideArrays::kTrusted;
        return (sides_.states[t] & kBoth) == kBoth;
    }
    __device__ void find_fan(std::uint32_t corner) const {
        const std::uint32_t t = corner / 3, k = corner % 3;
        if (!s_.sides.kept[t]) return;
        const step::FanView<const std::int32_t(*)[3], const std::uint8_t(*)[3]> view{
            s_.lattice.triangles, s_.lattice.neighbours, s_.sides.open, s_.sides.kept};
        std::uint32_t first = corner;
        step::each_of_fan(view, {t, k}, [&](const step::Corner& c) {
            first = min(first, c.number());
            return true;
        });
        a_.firsts[corner] = first;
        if (first != corner) return;
        const std::uint32_t v = s_.lattice.triangles[t][k];
        atomicAdd(&a_.fans[v], 1);
        a_.next[corner] = atomicExch(&a_.lists[v], corner);
    }
    // Those of a vertex by their first corners.
    __device__ void number_fans(std::uint32_t v, std::uint32_t before) const {
        for (std::uint32_t i = a_.lists[v]; i != kNone; i = a_.next[i]) {
            std::uint32_t number = before;
            for (std::uint32_t j = a_.lists[v]; j != kNone; j = a_.next[j]) number += j < i;
            a_.numbers[i] = number;
            if (number >= s_.sizes.most_points) continue;
            s_.sheet.olds[number] = v;
            s_.sheet.points[number] = s_.lattice.points[v];
        }
    }
    __device__ void put_triangle(unsigned t, unsigned at) const {
        const std::uint32_t* const firsts = a_.firsts + 3 * t;
        s_.sheet.triangles[at] = {a_.numbers[firsts[0]], a_.numbers[firsts[1]], a_.numbers[firsts[2]]};
        s_.sheet.origins[at] = t;
    }
    __device__ TriangleWarp pixels_of(unsigned t) const {
        const Vec2f* const p = sides_.corners[t];
        return {view_, p[0], p[1], p[2]};
    }
    // Calls visit(pixel, first, last, before): of a pixel that the surface is fitted to, whether its run
    // begins and ends with it, and how many runs begin before it. By all lanes; returns the number of runs.
    template <typename Visit>
    __device__ unsigned each_fitted(unsigned lane, unsigned t, const Visit& visit) const {
        unsigned count = 0;
        pixels_of(t).each_pixel([&](const LanePixel& pixel) {
            const auto is_fitted = [&](std::uint32_t i) {
                return sides_.places[i] == step::place_of(t, true) && (view_.flags[i] & step::kTrusted);
            };
            const bool fitted = pixel.valid && is_fitted(pixel.index);
            const bool first = fitted && !(pixel.x > pixel.first && is_fitted(pixel.index - 1)),
                       last = fitted && !(pixel.x + 1 < pixel.end && is_fitted(pixel.index + 1));
            const unsigned firsts = __ballot_sync(kAllLanes, first);
            if (fitted) visit(pixel, first, last, count + __popc(firsts & ((1u << lane) - 1)));
            count += __popc(firsts);
        });
        return count;
    }
    __device__ void count_runs(unsigned lane, unsigned t) const {
        const unsigned count = each_fitted(lane, t, [](const LanePixel&, bool, bool, unsigned) {});
        if (lane == 0) a_.runs[t] = count;
    }
    __device__ void put_runs(unsigned lane, unsigned t, PixelRun* runs) const {
        if (is_simple(t)) {
            pixels_of(t).each_rows([&](const LaneRows& rows) {
                const unsigned own = __ballot_sync(kAllLanes, rows.own);
                if (rows.own) runs[__popc(own & ((1u << lane) - 1))] = rows.run;
                runs += __popc(own);
            });
            return;
        }
        each_fitted(lane, t, [&](const LanePixel& pixel, bool first, bool last, unsigned before) {
            PixelRun* const run = runs + before - !first;  // a run that began before is the last of those
            if (first) run->y = pixel.y, run->first = pixel.x;
            if (last) run->end = pixel.x + 1;
        });
    }

    const SheetState& s_;
    const SideArrays& sides_;
    const FanArrays& a_;
    step::PixelView view_;
};

// As SideFinder::collect_pixels and open_fans, with the sheet's points. sides.runs has room for run_room().
template <typename Crew>
__device__ void open_fans(Crew& crew, const SheetState& s, const SideArrays& sides, const FanArrays& a) {
    DeviceFans(s, sides, a).open(crew);
}

}  // namespace hexrelief::cuda
