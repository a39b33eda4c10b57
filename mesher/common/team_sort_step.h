// Counting sort by a team of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipeline/base/shared_memory_step.h"

namespace hexrelief::step {

// Items in numbered buckets.
struct BucketView {
    unsigned *starts, *ends;  // bucket b holds items[starts[b]] .. items[ends[b] - 1], ascending
    std::uint32_t* items;

    HEXRELIEF_HD const std::uint32_t* begin(std::size_t bucket) const { return items + starts[bucket]; }
    HEXRELIEF_HD const std::uint32_t* end(std::size_t bucket) const { return items + ends[bucket]; }
};

// Sorts items into buckets. each(put) must call put(bucket, item) once for each item, by any thread, and end
// with a barrier; all threads call it twice, once to count the items and once to store them.
template <typename Team, typename Each>
HEXRELIEF_TEAM void sort_into(Team& team, std::size_t buckets, const BucketView& table, const Each& each) {
    team.each(buckets, [&](std::size_t b) { table.ends[b] = 0; });
    each([&](std::uint32_t bucket, std::uint32_t) { add_to(table.ends + bucket, 1); });
    exclusive_scan(
        team, buckets, [&](std::size_t b) -> unsigned { return table.ends[b]; },
        [&](std::size_t b, unsigned before) { table.starts[b] = table.ends[b] = before; });
    each([&](std::uint32_t bucket, std::uint32_t item) {
        table.items[add_to(table.ends + bucket, 1)] = item;
    });
    team.each(buckets, [&](std::size_t b) {  // a few items each, which one thread alone has put in order
        std::uint32_t* const items = table.items + table.starts[b];
        for (unsigned i = 1, count = table.ends[b] - table.starts[b]; i < count; ++i) {
            const std::uint32_t item = items[i];
            unsigned at = i;
            for (; at > 0 && items[at - 1] > item; --at) items[at] = items[at - 1];
            items[at] = item;
        }
    });
}

}  // namespace hexrelief::step
