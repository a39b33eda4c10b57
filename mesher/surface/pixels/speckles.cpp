#include "mesher/surface/pixels/speckles.h"

#include <algorithm>

#include "pipeline/data/union_find.h"

namespace hexrelief::surface {
namespace {

// A run of connected pixels of a row.
struct Run {
    std::uint32_t first, end;  // indices in the map
};

// Runs in the map's order, and the sets of runs that make up regions.
struct Regions {
    std::vector<Run> runs;
    UnionFind sets;  // sets of indices of runs

    void add(const Run& run) {
        runs.push_back(run);
        sets.add();
    }
    void append(const Regions& other) {
        runs.insert(runs.end(), other.runs.begin(), other.runs.end());
        sets.append(other.sets);
    }
};

// Joins the regions of touching runs of two rows if they are connected: if open(from, to) is true for the
// pixels from .. to - 1 of the lower row, which lie below both runs.
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
            // the upper run reaches beyond this one, above the next run as well
            if (runs[above].end + width > runs[own].end) break;
        }
}

// Finds all runs and joins them to regions; each thread finds those of its own rows. find(row, put) calls
// put(first, end) for the runs of the row that starts at pixel `row`.
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

// Returns the pixels of all regions with fewer than least_px pixels.
std::vector<std::uint32_t> pixels_of_speckles(Regions regions, double least_px) {
    const std::uint32_t count = static_cast<std::uint32_t>(regions.runs.size());
    std::vector<int> areas(count, 0);  // stored at each region's first run
    for (std::uint32_t i = 0; i < count; ++i)
        areas[regions.sets.find(i)] += static_cast<int>(regions.runs[i].end - regions.runs[i].first);
    std::vector<std::uint32_t> pixels;
    for (std::uint32_t i = 0; i < count; ++i)
        if (areas[regions.sets.find(i)] < least_px)
            for (std::uint32_t p = regions.runs[i].first; p < regions.runs[i].end; ++p) pixels.push_back(p);
    return pixels;
}

constexpr std::uint8_t kUnsettled = 128, kQueued = 64;  // flags of pixels that are being absorbed

template <typename Visit>
void each_neighbour(const PixelSurfaces& s, std::uint32_t i, const Visit& visit) {
    const std::uint32_t width = static_cast<std::uint32_t>(s.width),
                        count = static_cast<std::uint32_t>(s.disparity.size());
    if (i % width != 0) visit(i - 1);
    if ((i + 1) % width != 0) visit(i + 1);
    if (i >= width) visit(i - width);
    if (i + width < count) visit(i + width);
}

// Gives the pixels disparities from the region's border inwards, a ring per round, each from its settled
// neighbours: exact enough for the few pixels that these are.
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
