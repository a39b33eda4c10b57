// Counting sort: items in numbered buckets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hexrelief {

struct Buckets {
    std::vector<std::uint32_t> starts, items;  // bucket b holds items[starts[b]] .. items[starts[b + 1] - 1]

    std::span<const std::uint32_t> operator[](std::size_t bucket) const {
        return {items.data() + starts[bucket], starts[bucket + 1] - starts[bucket]};
    }
};

// Sorts items into `buckets` buckets. each(put) must call put(bucket, item) for all items; it is called
// twice, once to count the items and once to store them. The items of a bucket keep their order.
template <typename Each>
Buckets sort_into(std::size_t buckets, const Each& each) {
    Buckets table{std::vector<std::uint32_t>(buckets + 2, 0), {}};
    // Counts are stored two entries further on, so that filling the buckets moves each start
    // to its final value.
    each([&](std::uint32_t bucket, std::uint32_t) { ++table.starts[bucket + 2]; });
    for (std::size_t b = 2; b < table.starts.size(); ++b) table.starts[b] += table.starts[b - 1];
    table.items.resize(table.starts.back());
    each([&](std::uint32_t bucket, std::uint32_t item) { table.items[table.starts[bucket + 1]++] = item; });
    table.starts.pop_back();
    return table;
}

}  // namespace hexrelief
