// Fit of the cameras' parameters to matches: they bring each match to one row.
#pragma once

#include <vector>

#include "pipeline/alignment/views.h"

namespace hexrelief::alignment {

// Returns the parameters of cameras that stand parallel; that are turned so that the matches lie on the same
// rows on average; and that are turned towards the same places as well. Needs at least 2 matches.
std::vector<Parameters> starts_of(const Camera& camera, const std::vector<Match>& matches);

// What is believed before the fit.
struct Prior {
    // One standard deviation of each parameter from 0; 0 = held at 0.
    Parameters deviations = {};
    // 1 = the scene lies in front of both cameras if the pictures are in order, -1 = if they are exchanged;
    // 0 = not asked. The belief is soft: all matches behind infinity weigh as much as a parameter that is
    // four standard deviations off.
    int order = 0;
};

struct Fit {
    Parameters parameters = {};  // rounded to 2^-20
    Parameters deviations = {};  // one standard deviation of each after the fit; 0 if held
};

// Minimises the rows' offsets by Levenberg-Marquardt steps, with Geman-McClure weights whose width falls from
// that of the rows at the start (or from `width_px` if that is above 0) to 1 px. Matches are summed in their
// order and nothing is drawn at random: the same input gives the same bits. Needs at least 8 matches.
Fit fit_views(const Camera& camera, const std::vector<Match>& matches, const Prior& prior,
              const Parameters& start, double width_px = 0);

// Returns the mean of r^2 / (1 + r^2) over the rows' offsets: 0 = all on their rows, 1 = none.
double row_cost(const Views& views, const std::vector<Match>& matches);

}  // namespace hexrelief::alignment
