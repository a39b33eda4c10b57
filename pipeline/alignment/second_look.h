// Points looked for again in pictures that are aligned already.
#pragma once

#include <vector>

#include "pipeline/alignment/estimate.h"
#include "pipeline/alignment/grey_picture.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::alignment {

// Returns matches like the estimate's own, found in the pictures as the estimate aligns them: patches that
// were turned or scaled against each other are alike then, so that there are more matches and truer ones.
// left, right: the pictures that the estimate's matches were found in.
std::vector<Match> look_again(const Estimate& estimate, const GreyPicture& left, const GreyPicture& right,
                              ThreadPool& pool);

}  // namespace hexrelief::alignment
