#include "mesher/surface/topology/edge_votes_simd.h"

#include <cstring>

#include "mesher/common/simd.h"
#include "mesher/common/simd_bytes.h"
#include "mesher/surface/topology/label_triangles_step.h"

namespace hexrelief {
namespace {

constexpr int K = static_cast<int>(kPlaceLanes);
constexpr int kClosedBit = 16;  // votes for an edge that is open count 1, others so much

// Loops over lanes as arrays are not all found to be vectors.
typedef std::uint32_t Lanes __attribute__((vector_size(4 * kPlaceLanes)));
typedef std::uint64_t Pairs __attribute__((vector_size(4 * kPlaceLanes)));
typedef std::int32_t SignedLanes __attribute__((vector_size(4 * kPlaceLanes)));

// No branches on pixels, which could not be foreseen: pairs within the triangle, or with what is no
// neighbour's, are of no edge. What a pair says is step::pair_vote()'s.
HEXRELIEF_VECTORS void add_votes(const PlaceView& pixels, const PixelRun* runs, std::size_t count,
                                 std::uint32_t own_side, const std::uint32_t* towards,
                                 std::uint32_t* __restrict counts) {
    const std::uint32_t t0 = towards[0], t1 = towards[1], t2 = towards[2];
    const SignedLanes numbers = {0, 1, 2, 3, 4, 5, 6, 7};
    const Pairs pair_shifts = {0, 16, 32, 48};
    Lanes sums0{}, sums1{}, sums2{};
    std::uint32_t beside0 = 0, beside1 = 0, beside2 = 0;
    for (std::size_t r = 0; r < count; ++r) {
        const PixelRun run = runs[r];
        if (run.first >= run.end) continue;
        const std::size_t start = static_cast<std::size_t>(run.y) * static_cast<std::size_t>(pixels.width);
        const std::uint32_t* const row = pixels.places + start;
        const std::uint8_t* const flags = pixels.flags + start;
        const auto add_one = [&](int x, int other_x, int flag_x) {
            const std::uint32_t other = row[other_x], own = row[x] == own_side, others = other & 1u,
                                triangle = other >> 1, both = own & others;
            const std::uint32_t vote =
                flags[flag_x] & step::kDiscontinuityRight ? both : (own ^ others) | both << kClosedBit;
            beside0 += triangle == t0 ? vote : 0u;
            beside1 += triangle == t1 ? vote : 0u;
            beside2 += triangle == t2 ? vote : 0u;
        };
        if (run.first > 0) add_one(run.first, run.first - 1, run.first - 1);
        if (run.end < pixels.width) add_one(run.end - 1, run.end, run.end - 1);
        for (int x = run.first; x < run.end; x += K) {
            Lanes own_places;
            std::memcpy(&own_places, row + x, sizeof own_places);
            const Lanes own = (Lanes)(own_places == own_side) & 1u, valid = (Lanes)(numbers < run.end - x);
            const auto add = [&](const std::uint32_t* next, const std::uint8_t* discontinuities) {
                Lanes other;
                const std::uint64_t eight = eight_at(discontinuities + x, discontinuities + x + K);
                std::memcpy(&other, next + x, sizeof other);
                // all ones in the lanes of pixels with a discontinuity, two pixels a pair
                const Pairs pair = (Pairs{} + eight) >> pair_shifts;
                const Lanes parted =
                    (Lanes)((SignedLanes)((pair & step::kDiscontinuityDown) << 30 | pair << 54) >> 31);
                const Lanes others = other & 1u, both = own & others, triangle = other >> 1;
                const Lanes whole = (own ^ others) | both << kClosedBit;
                const Lanes vote = (whole ^ (parted & (whole ^ both))) & valid;
                sums0 += (Lanes)(triangle == t0) & vote;
                sums1 += (Lanes)(triangle == t1) & vote;
                sums2 += (Lanes)(triangle == t2) & vote;
            };
            if (run.y > 0) add(row - pixels.width, flags - pixels.width);
            if (run.y + 1 < pixels.height) add(row + pixels.width, flags);
        }
    }
    const Lanes sums[3] = {sums0, sums1, sums2};
    const std::uint32_t beside[3] = {beside0, beside1, beside2};
    for (int e = 0; e < 3; ++e) {
        counts[2 * e] = beside[e] & 0xffffu;
        counts[2 * e + 1] = beside[e] >> kClosedBit;
        for (int k = 0; k < K; ++k) {
            counts[2 * e] += sums[e][k] & 0xffffu;
            counts[2 * e + 1] += sums[e][k] >> kClosedBit;
        }
    }
}

HEXRELIEF_VECTORS bool find_others(const PlaceView& pixels, const PixelRun* runs, std::size_t count,
                                   std::uint32_t own_side) {
    const SignedLanes numbers = {0, 1, 2, 3, 4, 5, 6, 7};
    Lanes others{};
    for (std::size_t r = 0; r < count; ++r) {
        const PixelRun run = runs[r];
        const std::uint32_t* const row =
            pixels.places + static_cast<std::size_t>(run.y) * static_cast<std::size_t>(pixels.width);
        for (int x = run.first; x < run.end; x += K) {
            Lanes places;
            std::memcpy(&places, row + x, sizeof places);
            others |= ((places | 1u) ^ own_side) & (Lanes)(numbers < run.end - x);
        }
    }
    std::uint64_t any[K / 2];
    std::memcpy(any, &others, sizeof any);
    return (any[0] | any[1] | any[2] | any[3]) != 0;
}

}  // namespace

EdgeVotes count_votes(const PlaceView& pixels, std::span<const PixelRun> runs, std::uint32_t own_side,
                      const std::uint32_t towards[3]) {
    std::uint32_t counts[6];
    add_votes(pixels, runs.data(), runs.size(), own_side, towards, counts);
    return {{counts[0], counts[2], counts[4]}, {counts[1], counts[3], counts[5]}};
}

bool holds_others(const PlaceView& pixels, std::span<const PixelRun> runs, std::uint32_t own_side) {
    return find_others(pixels, runs.data(), runs.size(), own_side);
}

}  // namespace hexrelief
