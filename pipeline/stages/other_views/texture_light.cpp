#include "pipeline/stages/other_views/texture_light.h"

#include <utility>

namespace hexrelief::stages {
namespace {

using Light = TextureLevel::Light;

constexpr int kSweeps = 12;
constexpr int kMostSeam = 60;  // levels of three channels: what differs by more is another thing

// What a target's correction is compared with: another target's, or none where `other` is what is seen.
struct Link {
    static constexpr int kSeen = -1;
    int other = kSeen;
    Light step = {};  // that correction less the target's
};

struct Unknown {
    std::uint32_t target = 0;
    int count = 0;
    std::array<Link, 4> links;
};

// Returns what b lacks of a.
Light lacking(const TextureLevel::Colour& a, const TextureLevel::Colour& b) {
    return {float(a[0] - b[0]), float(a[1] - b[1]), float(a[2] - b[2])};
}

// The source that an offset leads to from (x, y), for the target there or beside it; -1 = that is none.
int source_of(const TextureLevel& level, int target, int x, int y, Offset offset) {
    if (offset.is_none() || !level.has(x + offset.x, y + offset.y)) return -1;
    const int source = level.at(x + offset.x, y + offset.y);
    return level.is_source_of(target, source) ? source : -1;
}

// Adds how the colours go on from the target at (x, y) to the cell at (u, v), if the sources tell.
void add_link(const TextureLevel& level, int x, int y, int u, int v, Unknown& unknown) {
    const int target = level.at(x, y), other = level.at(u, v);
    const bool is_seen = level.is_source_of(target, other),
               is_painted = !level.offsets[other].is_none() && level.are_one(target, other);
    if (!is_seen && !is_painted) return;
    const Offset own = level.offsets[target], its = level.offsets[other];
    Link link{is_seen ? Link::kSeen : other};
    if (is_seen || own != its) {
        const int here = source_of(level, target, x, y, own), beside = source_of(level, target, u, v, own),
                  there = is_seen ? other : source_of(level, other, u, v, its),
                  back = is_seen ? -1 : source_of(level, other, x, y, its);
        if (here < 0 || there < 0 || (beside < 0 && back < 0)) return;
        // Where both sources go on, the mean of both counts.
        const Light by_own = beside < 0 ? Light{} : lacking(level.seen[beside], level.seen[there]),
                    by_its = back < 0 ? Light{} : lacking(level.seen[here], level.seen[back]);
        const float share = beside < 0 || back < 0 ? 1.0F : 0.5F;
        float size = 0;
        for (int c = 0; c < 3; ++c) {
            link.step[c] = share * (by_own[c] + by_its[c]);
            size += std::abs(link.step[c]);
        }
        if (size > kMostSeam) return;
    }
    unknown.links[unknown.count++] = link;
}

// The unknowns of every second cell along rows and columns, and those between them: each depends on the
// other part's alone.
using Unknowns = std::array<std::vector<Unknown>, 2>;

Unknowns unknowns_of(const TextureLevel& level, ThreadPool& pool) {
    std::vector<Unknown> all(level.targets.size());
    pool.parallel_for_each(all.size(), [&](std::size_t i) {
        const int target = static_cast<int>(level.targets[i]), x = target % level.width,
                  y = target / level.width;
        all[i].target = level.targets[i];
        if (level.offsets[target].is_none()) return;
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
            if (level.has(x + dx, y + dy)) add_link(level, x, y, x + dx, y + dy, all[i]);
    });
    Unknowns parts;
    for (const Unknown& unknown : all)
        if (unknown.count > 0)
            parts[(unknown.target % level.width + unknown.target / level.width) % 2].push_back(unknown);
    return parts;
}

}  // namespace

void match_light(TextureLevel& level, const TextureLevel* coarser, ThreadPool& pool) {
    level.light.assign(level.offsets.size(), Light{});
    for (const std::uint32_t target : level.targets)
        if (coarser != nullptr)
            level.light[target] = coarser->light[coarser->at(static_cast<int>(target) % level.width / 2,
                                                             static_cast<int>(target) / level.width / 2)];
    const auto settle = [&](const Unknown& unknown) {
        Light sum = {};
        for (int k = 0; k < unknown.count; ++k) {
            const Link& link = unknown.links[k];
            for (int c = 0; c < 3; ++c)
                sum[c] += (link.other == Link::kSeen ? 0 : level.light[link.other][c]) - link.step[c];
        }
        for (int c = 0; c < 3; ++c) level.light[unknown.target][c] = sum[c] / float(unknown.count);
    };
    const Unknowns parts = unknowns_of(level, pool);
    pool.run([&](int thread) {
        for (int sweep = 0; sweep < kSweeps; ++sweep)
            for (const std::vector<Unknown>& part : parts) {
                const std::size_t end = pool.share(part.size(), thread + 1);
                for (std::size_t i = pool.share(part.size(), thread); i < end; ++i) settle(part[i]);
                pool.barrier();
            }
    });
}

}  // namespace hexrelief::stages
