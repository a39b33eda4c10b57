// Union-find: disjoint sets of numbered elements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace hexrelief {

// The root of a set is always its smallest element, so that the result does not depend on the order of joins.
class UnionFind {
  public:
    // Makes `count` elements, each a set of its own.
    explicit UnionFind(std::size_t count = 0) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
    }
    // Adds one element as a set of its own.
    void add() { parents_.push_back(static_cast<std::uint32_t>(parents_.size())); }
    void clear() { parents_.clear(); }

    std::uint32_t find(std::uint32_t i) {
        while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        if (a < b) parents_[b] = a;
        if (b < a) parents_[a] = b;
    }

  private:
    std::vector<std::uint32_t> parents_;
};

}  // namespace hexrelief
