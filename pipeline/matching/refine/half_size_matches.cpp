#include "pipeline/matching/refine/half_size_matches.h"

#include <utility>

#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/half_size_match_step.h"

namespace hexrelief::matching {

void add_half_size_matches(const HalfSizeMatches& half, int min_px, TrustedMatches& matches,
                           ThreadPool& pool) {
    const DisparityOut left = matches.left.view();
    const DisparityView half_left = half.left.view(), right = std::as_const(matches.right).view();
    for_each_row(pool, left.height, [&](int y) {
        for (int x = 0; x < left.width; ++x)
            if (left.at(x, y) < 0)
                left.at(x, y) =
                    step::half_size_match(half_left, half.min_px, right.row(y), left.width, min_px, x, y);
    });
}

}  // namespace hexrelief::matching
