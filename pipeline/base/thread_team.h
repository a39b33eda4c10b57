// The threads of a pool as a team that runs one control flow together. CooperativeGrid (cuda/common/grid.cuh)
// is the same on a device: code that takes either as `Team` is written once for both.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "pipeline/base/thread_pool.h"

namespace hexrelief {

// All threads must call each member function together; `visit` must not depend on which thread calls it.
class ThreadTeam {
  public:
    static constexpr int kBlock = 32;  // pixels of a row that a thread works on at a time

    // Calls work(team) on all threads of the pool.
    template <typename Work>
    static void run(ThreadPool& pool, const Work& work) {
        Board board{{}, std::vector<std::uint64_t>(static_cast<std::size_t>(pool.size()))};
        pool.run([&](int thread) {
            ThreadTeam team(pool, thread, board);
            work(team);
        });
    }

    bool is_first() const { return thread_ == 0; }
    // A barrier: all threads see after it what any thread wrote before it.
    void wait() const { pool_.barrier(); }
    // True for all threads if `mine` is true for any; includes a barrier.
    bool any(bool mine) {
        // Two slots are enough: before the next vote but one, all threads have passed the next one's barrier.
        std::atomic<unsigned>& last_yes = board_.votes[++vote_ % 2];
        if (mine) last_yes.store(vote_, std::memory_order_relaxed);
        wait();
        return last_yes.load(std::memory_order_relaxed) == vote_;
    }
    // Calls visit(i) for each i < count, followed by a barrier.
    template <typename Visit>
    void each(std::size_t count, const Visit& visit) const {
        deal<kItems>(count, visit);
        wait();
    }
    // Calls visit(x, y) for the first pixel of each block of kBlock pixels of a row, fewer at its end;
    // followed by a barrier.
    template <typename Visit>
    void each_block(int width, int height, const Visit& visit) const {
        deal<kRows>(static_cast<std::size_t>(height), [&](std::size_t y) {
            for (int x = 0; x < width; x += kBlock) visit(x, static_cast<int>(y));
        });
        wait();
    }
    // Replaces the numbers of each line by their prefix sums, followed by a barrier. Lines begin `apart`
    // numbers apart, and hold `count` numbers that are `stride` apart.
    void sum_lines(std::uint32_t* numbers, std::size_t lines, std::size_t apart, std::size_t count,
                   std::size_t stride) const {
        each(lines, [&](std::size_t line) {
            std::uint32_t* const first = numbers + line * apart;
            for (std::size_t i = 1; i < count; ++i) first[i * stride] += first[(i - 1) * stride];
        });
    }

    // Calls visit(i, sum of value(j) over all j < i) for each i < count, followed by a barrier; returns the
    // total. The thread that visits i reads value(i) before.
    template <typename Value, typename Visit>
    friend auto exclusive_scan(const ThreadTeam& team, std::size_t count, const Value& value,
                               const Visit& visit) {
        using Sum = decltype(value(std::size_t{0}));  // at most 64 bits
        std::vector<std::uint64_t>& sums = team.board_.sums;
        const int thread = static_cast<int>(team.thread_);
        const std::size_t first = team.pool_.share(count, thread), end = team.pool_.share(count, thread + 1);
        std::uint64_t& own = sums[team.thread_] = 0;
        for (std::size_t i = first; i < end; ++i) own += value(i);
        team.wait();
        Sum sum = static_cast<Sum>(std::accumulate(sums.begin(), sums.begin() + thread, std::uint64_t{0}));
        const Sum all = static_cast<Sum>(std::accumulate(sums.begin(), sums.end(), std::uint64_t{0}));
        for (std::size_t i = first; i < end; ++i) {
            const Sum before = sum;
            sum += value(i);
            visit(i, before);
        }
        team.wait();
        return all;
    }

  private:
    // What the threads tell each other.
    struct Board {
        std::atomic<unsigned> votes[2];
        std::vector<std::uint64_t> sums;  // per thread
    };
    static constexpr std::size_t kItems = 64, kRows = 8;

    ThreadTeam(ThreadPool& pool, int thread, Board& board)
        : pool_(pool), thread_(static_cast<std::size_t>(thread)), board_(board) {}

    // Deals chunks to the threads in turn, because one half of an image may hold most of the work.
    template <std::size_t kChunk, typename Visit>
    void deal(std::size_t count, const Visit& visit) const {
        for (std::size_t first = kChunk * thread_; first < count; first += kChunk * pool_.size())
            for (std::size_t i = first, end = std::min(first + kChunk, count); i < end; ++i) visit(i);
    }

    ThreadPool& pool_;
    std::size_t thread_;
    Board& board_;
    unsigned vote_ = 0;
};

}  // namespace hexrelief
