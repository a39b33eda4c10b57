// Tells a left view from a right one by what only one of them shows.
#pragma once

#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

// True if the match's left view is surely the left one, whatever the sign of its disparities. Pixels that
// only one view shows lie between a near and a far surface, and belong to the far one: the picture's edge,
// the silhouette of the near surface, is their right end in a left view and their left end in a right view.
bool is_surely_left(const stages::SmallMatch& match);
// True if it is surely the right one.
bool is_surely_right(const stages::SmallMatch& match);

}  // namespace hexrelief::checks
