// Tests what a team's threads do together against plain loops, on several numbers of threads.
#include "pipeline/base/thread_team.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include "pipeline/base/shared_memory_step.h"
#include "pipeline/data/union_find.h"

namespace hexrelief::testing_mesher {
namespace {

constexpr std::array kThreads{1, 2, 3, 7};

TEST(ThreadTeam, VisitsEachItemAndBlockOnce) {
    constexpr int kWidth = 71, kHeight = 19;
    for (const int threads : kThreads) {
        ThreadPool pool(threads);
        std::vector<int> items(1000, 0), pixels(kWidth * kHeight, 0);
        ThreadTeam::run(pool, [&](const ThreadTeam& team) {
            team.each(items.size(), [&](std::size_t i) { ++items[i]; });
            team.each_block(kWidth, kHeight, [&](int x0, int y) {
                for (int x = x0; x < std::min(x0 + ThreadTeam::kBlock, kWidth); ++x) ++pixels[y * kWidth + x];
            });
        });
        EXPECT_EQ(items, std::vector<int>(items.size(), 1)) << threads;
        EXPECT_EQ(pixels, std::vector<int>(pixels.size(), 1)) << threads;
    }
}

TEST(ThreadTeam, SumsAsOneThreadDoes) {
    std::mt19937 random(7);
    std::vector<std::uint64_t> values(333);
    for (std::uint64_t& v : values) v = std::uint64_t{random()} << 20;  // beyond 32 bits
    std::vector<std::uint64_t> expected(values.size());
    std::exclusive_scan(values.begin(), values.end(), expected.begin(), std::uint64_t{0});
    for (const int threads : kThreads) {
        ThreadPool pool(threads);
        std::vector<std::uint64_t> sums(values.size()), totals(static_cast<std::size_t>(threads));
        std::atomic<std::size_t> next = 0;
        ThreadTeam::run(pool, [&](const ThreadTeam& team) {
            totals[next++] = exclusive_scan(
                team, values.size(), [&](std::size_t i) { return values[i]; },
                [&](std::size_t i, std::uint64_t before) { sums[i] = before; });
        });
        EXPECT_EQ(sums, expected) << threads;
        EXPECT_EQ(totals, std::vector<std::uint64_t>(totals.size(), expected.back() + values.back()));
    }
}

TEST(ThreadTeam, SumsLinesInBothDirections) {
    constexpr std::size_t kColumns = 9, kRows = 5;
    ThreadPool pool(3);
    std::vector<std::uint32_t> numbers(kColumns * kRows, 1);
    ThreadTeam::run(pool, [&](const ThreadTeam& team) {
        team.sum_lines(numbers.data(), kRows, kColumns, kColumns, 1);
        team.sum_lines(numbers.data(), kColumns, 1, kRows, kColumns);
    });
    for (std::size_t i = 0; i < numbers.size(); ++i)
        EXPECT_EQ(numbers[i], (i % kColumns + 1) * (i / kColumns + 1)) << i;
}

// One thread after the other says yes, and in every second vote nobody.
TEST(ThreadTeam, VotesTogether) {
    for (const int threads : kThreads) {
        ThreadPool pool(threads);
        std::atomic<int> next = 0, wrong = 0;
        ThreadTeam::run(pool, [&](ThreadTeam& team) {
            const int own = next++;
            for (int vote = 0; vote < 40; ++vote) {
                const bool is_yes = vote % 2 == 0;
                if (team.any(is_yes && vote / 2 % threads == own) != is_yes) ++wrong;
            }
        });
        EXPECT_EQ(wrong, 0) << threads;
    }
}

TEST(SharedSets, JoinAsOneThreadDoes) {
    constexpr unsigned kEntries = 2000;
    std::mt19937 random(11);
    std::vector<std::array<unsigned, 2>> pairs(1500);
    for (auto& pair : pairs)
        pair = {static_cast<unsigned>(random() % kEntries), static_cast<unsigned>(random() % kEntries)};
    UnionFind expected(kEntries);
    for (const auto& [a, b] : pairs) expected.join(a, b);
    for (const int threads : kThreads) {
        ThreadPool pool(threads);
        std::vector<unsigned> parents(kEntries);
        std::iota(parents.begin(), parents.end(), 0u);
        const step::SharedSets sets{parents.data()};
        ThreadTeam::run(pool, [&](const ThreadTeam& team) {
            team.each(pairs.size(), [&](std::size_t i) { sets.join(pairs[i][0], pairs[i][1]); });
        });
        for (unsigned i = 0; i < kEntries; ++i) ASSERT_EQ(sets.root(i), expected.find(i)) << threads;
    }
}

}  // namespace
}  // namespace hexrelief::testing_mesher
