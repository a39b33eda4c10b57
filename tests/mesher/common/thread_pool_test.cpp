// Tests the thread pool, and that the mesh has the same bytes for any number of threads and in repeated runs.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "mesher/quality/quality.h"
#include "pipeline/base/thread_pool.h"
#include "tests/mesher/densities.h"

namespace hexrelief::testing_mesher {
namespace {

bool same_bytes(const HexMesh2D& a, const HexMesh2D& b) {
    return a.columns == b.columns && a.rows == b.rows && a.iterations == b.iterations &&
           a.positions == b.positions;
}

TEST(Threads, SameBytesForAnyNumberAndAgain) {
    MeshConfig coarse_to_fine{.t_max = 25};
    MeshConfig paper = coarse_to_fine;
    paper.levels = 1;
    paper.co = 20;
    paper.delta = 1;
    paper.border = MeshBorder::free;
    MeshConfig sequential = paper;
    sequential.method = MeshMethod::sequential;
    const std::vector<NamedDensity> densities = {
        {"bumps", bumps_density(211, 163)},    {"ramp", ramp_density(160, 150)},
        {"noise", noise_density(150, 131, 4)}, {"bright pixel", bright_pixel_density(150, 150, 149, 0)},
        {"tiny", bumps_density(18, 19)},       {"nothing", flat_density(90, 80, 0)}};
    for (const NamedDensity& d : densities)
        for (const MeshConfig& config : {coarse_to_fine, paper, sequential}) {
            const HexMesh2D one = mesher::solve_mesh(d.density, config, 1, {});
            const double cost = quality::measure_quality(one, d.density, 1).percent_cost;
            for (const int threads : {1, 2, 3, 5}) {
                EXPECT_TRUE(same_bytes(one, mesher::solve_mesh(d.density, config, threads, {})))
                    << d.name << ", " << threads << " threads; " << describe(d.density, config);
                EXPECT_EQ(cost, quality::measure_quality(one, d.density, threads).percent_cost);
            }
        }
}

TEST(Threads, MoreThanRowsAndCells) {
    MeshConfig config{.t_max = 10};
    const DensityMap density = bumps_density(24, 22);
    EXPECT_EQ(solve(density, config, 1).positions, solve(density, config, 16).positions);
}

TEST(Progress, RisesToOneAndMayStop) {
    MeshConfig config{.t_max = 40};
    const DensityMap density = bumps_density(160, 150);
    for (const int threads : {1, 3}) {
        std::vector<double> shares;
        mesher::solve_mesh(density, config, threads, [&](double share) { shares.push_back(share); });
        ASSERT_GT(shares.size(), 4u);
        for (std::size_t i = 1; i < shares.size(); ++i) EXPECT_GE(shares[i], shares[i - 1]);
        EXPECT_GE(shares.front(), 0);
        EXPECT_LE(shares.back(), 1);
        int calls = 0;
        const auto stop = [&](double) {
            if (++calls == 3) throw std::runtime_error("enough");
        };
        EXPECT_THROW(mesher::solve_mesh(density, config, threads, stop), std::runtime_error);
        EXPECT_EQ(calls, 3);
    }
}

TEST(ThreadPool, EveryThreadPassesEveryBarrier) {
    for (const int size : {1, 2, 3, 7}) {
        ThreadPool pool(size);
        std::vector<int> counts(size);
        std::atomic<bool> torn = false;
        for (int run = 0; run < 20; ++run)
            pool.run([&](int thread) {
                for (int i = 0; i < 50; ++i) {
                    ++counts[thread];
                    pool.barrier();
                    for (const int count : counts)
                        if (count != counts[thread]) torn = true;
                    pool.barrier();
                }
            });
        EXPECT_FALSE(torn) << size << " threads";
        for (const int count : counts) EXPECT_EQ(count, 1000);
    }
}

TEST(ThreadPool, WhatOneThreadThrowsEndsAll) {
    for (const int size : {1, 2, 3, 7}) {
        ThreadPool pool(size);
        for (int failing = 0; failing < size; ++failing) {
            std::atomic<int> passed = 0;
            const auto work = [&](int thread) {
                pool.barrier();
                if (thread == failing) throw std::length_error("enough");
                pool.barrier();
                ++passed;
            };
            EXPECT_THROW(pool.run(work), std::length_error);
            EXPECT_EQ(passed, 0);
        }
        // The pool can be used again.
        std::atomic<int> calls = 0;
        pool.run([&](int) {
            pool.barrier();
            ++calls;
        });
        EXPECT_EQ(calls, size);
    }
}

TEST(ThreadPool, SharesCoverTheRangeOnce) {
    for (const int size : {1, 3, 8})
        for (const std::size_t count : {0u, 1u, 5u, 100u}) {
            ThreadPool pool(size);
            std::vector<std::atomic<int>> visits(count);
            pool.parallel_for(count, [&](std::size_t first, std::size_t last) {
                for (std::size_t i = first; i < last; ++i) ++visits[i];
            });
            for (const auto& v : visits) EXPECT_EQ(v, 1);
        }
}

TEST(ThreadPool, ChunksCoverTheRangeOnceHoweverLongTheyTake) {
    for (const int size : {1, 2, 3, 8})
        for (const std::size_t count : {0u, 1u, 5u, 31u, 64u, 1000u}) {
            ThreadPool pool(size);
            std::vector<std::atomic<int>> visits(count);
            for (int run = 0; run < 20; ++run)
                pool.parallel_for_chunks(count, [&](std::size_t first, std::size_t last) {
                    ASSERT_LT(first, last);
                    ASSERT_LE(last, count);
                    // all the work lies in one thread's share, from which others take over
                    if (first < count / 4) std::this_thread::sleep_for(std::chrono::microseconds(50));
                    for (std::size_t i = first; i < last; ++i) ++visits[i];
                });
            for (const auto& v : visits) EXPECT_EQ(v, 20);
        }
}

TEST(ThreadPool, ItemsAreVisitedOnceEach) {
    for (const int size : {1, 3, 8})
        for (const int count : {0, 1, 5, 100}) {
            ThreadPool pool(size);
            std::vector<std::atomic<int>> visits(static_cast<std::size_t>(count));
            pool.parallel_for_each(count, [&](int i) { ++visits[static_cast<std::size_t>(i)]; });
            pool.parallel_for_chunks<1>(visits.size(), [&](std::size_t i) { ++visits[i]; });
            pool.parallel_for_chunks(visits.size(), [&](std::size_t i) { ++visits[i]; });
            for (const auto& v : visits) EXPECT_EQ(v, 3);
        }
}

}  // namespace
}  // namespace hexrelief::testing_mesher
