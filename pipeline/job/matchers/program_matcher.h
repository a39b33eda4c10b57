// Matches pairs by a program of the user's.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pipeline/job/log/run_log.h"
#include "pipeline/job/matchers/child_program.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// Asks the program of disparity.command or disparity.worker for both views' maps. The right view's comes from
// the pair seen in a mirror, in which the right camera is the left one: programs need no second way of being
// asked. One call at a time.
class ProgramMatcher {
  public:
    // range: of the disparities to be expected; the program sees them counted from its least one on. Returns
    // maps of the pair's size in its px. Throws Error(input) if the program fails, answers too late or gives
    // no map of the pair, Error(output) if there is no place for the pictures.
    stages::ViewMaps match(const StereoPair& pair, const stages::DisparityConfig& range, RunLog& log);

  private:
    DisparityMap answer(const StereoPair& pair, const std::string& view, const stages::DisparityConfig& range,
                        RunLog& log);

    std::vector<std::string> words_;  // of the worker that runs
    std::unique_ptr<ChildProgram> worker_;
};

}  // namespace hexrelief::job
