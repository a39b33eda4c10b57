// Points that both grey pictures show: corners, their binary descriptions, and matches of these.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/alignment/grey_picture.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::alignment {

// Which of two boxes of 5 x 5 px is lighter, for 256 pairs of boxes within 15 px of the corner.
using Descriptor = std::array<std::uint64_t, 4>;

struct Corner {
    int x = 0, y = 0;
    Descriptor descriptor = {};
};

// Returns about `count` corners at most: the strongest ones of each of 12 x 12 parts of the picture, by the
// structure tensor (Harmonic mean of its eigenvalues), none within 3 px of a stronger one. In whole numbers,
// and in an order that the number of threads does not change.
std::vector<Corner> find_corners(const GreyPicture& picture, int count, ThreadPool& pool);

// Returns the number of bits in which two descriptors differ, 0 to 256.
inline int hamming_distance(const Descriptor& a, const Descriptor& b) {
    // Sums the bits of bytes within each word: without a processor's own instruction that is as fast as any.
    std::uint64_t sums = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::uint64_t v = a[i] ^ b[i];
        v -= (v >> 1) & 0x5555555555555555u;
        v = (v & 0x3333333333333333u) + ((v >> 2) & 0x3333333333333333u);
        sums += (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    }
    // The eight bytes hold up to 32 each; their sum, up to 256, needs 16 bits.
    sums = (sums & 0x00ff00ff00ff00ffu) + ((sums >> 8) & 0x00ff00ff00ff00ffu);
    return static_cast<int>((sums * 0x0001000100010001u) >> 48);
}

// Positions in px of the working pictures; the centre of the first pixel is at (0, 0).
struct Point {
    double x = 0, y = 0;
};

struct Match {
    Point left, right;
};

// Returns corners that describe each other best in both directions and clearly better than any other, at
// three sizes of the pictures; the right position is refined to 1/64 px. Whole numbers throughout: the same
// matches in the same order for any number of threads.
std::vector<Match> find_matches(const GreyPicture& left, const GreyPicture& right, ThreadPool& pool);

// Returns the places of the matches that shift like at least three of their eight nearest in the left
// picture: by 2 px and a tenth of their distance more or less. shifts: one of each match, px.
std::vector<std::size_t> supported_by_neighbours(const std::vector<Match>& matches,
                                                 const std::vector<Point>& shifts);

}  // namespace hexrelief::alignment
