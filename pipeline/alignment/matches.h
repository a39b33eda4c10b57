// Points of the left picture found in the right one, at any place.
#pragma once

#include <vector>

#include "pipeline/alignment/grey_picture.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::alignment {

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

}  // namespace hexrelief::alignment
