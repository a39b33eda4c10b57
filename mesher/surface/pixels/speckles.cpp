#include "mesher/surface/pixels/speckles.h"

#include <algorithm>

#include "pipeline/data/union_find.h"

namespace hexrelief::surface {
namespace {

// Connected pixels of a row.
struct Run {
    std::uint32_t first, end;  // in the map
};

// Runs in the map's order, and which of them make up a region.
struct Regions {
    std::vector<Run> runs;
    UnionFind sets;  // of runs

    void add(const Run& run) {
        runs.push_back(run);
        sets.add();
    }
    void append(const Regions& other) {
        runs.insert(runs.end(), other.runs.begin(), other.runs.end());
        sets.append(other.sets);
    }
};

// Joins the regions of touching runs of two rows that are connected: where open(from, to) says so of the
// pixels from .. to - 1 of the lower row, which lie under both.
template <typename Open>
void join_rows(Regions& regions, std::size_t above, std::size_t above_end, std::size_t own_end,
               std::uint32_t width, const Open& open) {
    const std::vector<Run>& runs = regions.runs;
    for (std::size_t own = above_end; own < own_end; ++own)
        for (; above < above_end && runs[above].first + width < runs[own].end; ++above) {
            const std::uint32_t from = std::max(runs[own].first, runs[above].first + width),
                                to = std::min(runs[own].end, runs[above].end + width);
            if (from < to && open(from, to))
                regions.sets.join(static_cast<std::uint32_t>(above), static_cast<std::uint32_t>(own));
            if (runs[above].end + width > runs[own].end) break;  // it reaches below the next run as well
        }
}

// All runs, joined to regions; each thread finds those of its rows. find(row, put) calls put(first, end)
// for the runs of the row that starts at pixel `row`.
template <typename Find, typename Open>
Regions find_regions(const PixelSurfaces& s, ThreadPool& pool, const Find& find, const Open& open) {
    struct Band {
        Regions regions;
        std::size_t first_row_end = 0, last_row = 0;
    };
    const std::uint32_t width = static_cast<std::uint32_t>(s.width);
    std::vector<Band> bands(pool.size());
    pool.run([&](int thread) {
        Band& band = bands[thread];
        const std::vector<Run>& runs = band.regions.runs;
        const std::size_t first = pool.share(s.height, thread), end = pool.share(s.height, thread + 1);
        for (std::size_t y = first; y < end; ++y) {
            const std::size_t above = band.last_row, own = band.last_row = runs.size();
            find(static_cast<std::uint32_t>(y * width), [&](std::uint32_t from, std::uint32_t to) {
                band.regions.add({from, to});
            });
            if (y == first)
                band.first_row_end = runs.size();
            else
                join_rows(band.regions, above, own, runs.size(), width, open);
        }
    });
    Regions all = std::move(bands[0].regions);
    std::size_t above = bands[0].last_row;
    for (std::size_t k = 1; k < bands.size(); ++k) {
        const std::size_t offset = all.runs.size();
        if (pool.share(s.height, static_cast<int>(k)) == pool.share(s.height, static_cast<int>(k) + 1))
            continue;
        all.append(bands[k].regions);
        if (offset > 0) join_rows(all, above, offset, offset + bands[k].first_row_end, width, open);
        above = offset + bands[k].last_row;
    }
    return all;
}

// The pixels of the regions of fewer than least_px.
std::vector<std::uint32_t> pixels_of_speckles(Regions regions, double least_px) {
    const std::uint32_t count = static_cast<std::uint32_t>(regions.runs.size());
    std::vector<int> areas(count, 0);  // at a region's first run
    for (std::uint32_t i = 0; i < count; ++i)
        areas[regions.sets.find(i)] += static_cast<int>(regions.runs[i].end - regions.runs[i].first);
    std::vector<std::uint32_t> pixels;
    for (std::uint32_t i = 0; i < count; ++i)
        if (areas[regions.sets.find(i)] < least_px)
            for (std::uint32_t p = regions.runs[i].first; p < regions.runs[i].end; ++p) pixels.push_back(p);
    return pixels;
}

constexpr std::uint8_t kUnsettled = 128, kQueued = 64;  // flags while pixels are absorbed

template <typename Visit>
void each_neighbour(const PixelSurfaces& s, std::uint32_t i, const Visit& visit) {
    const std::uint32_t width = static_cast<std::uint32_t>(s.width),
                        count = static_cast<std::uint32_t>(s.disparity.size());
    if (i % width != 0) visit(i - 1);
    if ((i + 1) % width != 0) visit(i + 1);
    if (i >= width) visit(i - width);
    if (i + width < count) visit(i + width);
}

// From the silhouette inwards, a ring a round, each pixel from its nearest settled neighbour: the right
// answer for the few pixels that these are.
void absorb(PixelSurfaces& s, const std::vector<std::uint32_t>& pixels, step::Around kind) {
    for (const std::uint32_t i : pixels) s.flags[i] = kUnsettled;
    std::vector<std::uint32_t> ring, next;
    for (const std::uint32_t i : pixels) {
        bool touches = false;
        each_neighbour(s, i, [&](std::uint32_t j) { touches |= !(s.flags[j] & kUnsettled); });
        if (touches) ring.push_back(i);
    }
    for (std::vector<float> found; !ring.empty(); ring.swap(next)) {
        found.clear();
        next.clear();
        for (const std::uint32_t i : ring) {
            float own = step::nothing(kind);
            each_neighbour(s, i, [&](std::uint32_t j) {
                if (!(s.flags[j] & kUnsettled)) own = step::taken(own, s.disparity[j], kind);
            });
            found.push_back(own);
        }
        for (std::size_t k = 0; k < ring.size(); ++k) {
            s.disparity[ring[k]] = found[k];
            s.flags[ring[k]] = 0;
        }
        for (const std::uint32_t i : ring)
            each_neighbour(s, i, [&](std::uint32_t j) {
                if ((s.flags[j] & (kUnsettled | kQueued)) != kUnsettled) return;
                s.flags[j] |= kQueued;
                next.push_back(j);
            });
    }
}

}  // namespace

std::vector<std::uint32_t> absorb_holes(PixelSurfaces& s, double cell_px, ThreadPool& pool) {
    const std::uint32_t width = static_cast<std::uint32_t>(s.width);
    const auto find = [&](std::uint32_t row, const auto& put) {
        const std::uint32_t last = row + width;
        for (std::uint32_t end, i = row; i < last; i = end) {
            for (end = i; end < last && !(s.disparity[end] > 0);) ++end;
            if (end > i) put(i, end);
            while (end < last && s.disparity[end] > 0) ++end;
        }
    };
    const auto open = [](std::uint32_t, std::uint32_t) { return true; };
    const std::vector<std::uint32_t> pixels = pixels_of_speckles(find_regions(s, pool, find, open), cell_px);
    absorb(s, pixels, step::Around::hole);
    return pixels;
}

std::vector<std::uint32_t> absorb_speckles(PixelSurfaces& s, int least_px, ThreadPool& pool) {
    const std::uint32_t width = static_cast<std::uint32_t>(s.width);
    const auto find = [&](std::uint32_t row, const auto& put) {
        const std::uint32_t last = row + width - 1;
        for (std::uint32_t end, i = row; i <= last; i = end) {
            end = i + 1;
            while (end <= last && !(s.flags[end - 1] & step::kDiscontinuityRight)) ++end;
            put(i, end);
        }
    };
    const auto open = [&](std::uint32_t from, std::uint32_t to) {
        return std::any_of(&s.flags[from - width], &s.flags[to - width],
                           [](std::uint8_t f) { return !(f & step::kDiscontinuityDown); });
    };
    const std::vector<std::uint32_t> pixels = pixels_of_speckles(find_regions(s, pool, find, open), least_px);
    absorb(s, pixels, step::Around::speckle);
    return pixels;
}

}  // namespace hexrelief::surface
