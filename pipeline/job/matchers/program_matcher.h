// Matches pairs by a program of the user's.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pipeline/job/log/run_log.h"
#include "pipeline/job/matchers/child_program.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// Asks the program of disparity.command or disparity.worker, or the project's own for disparity.model, for
// both views' maps. The right view's comes from the pair seen in a mirror, in which the right camera is the
// left one: programs need no second way of being asked. One call at a time.
class ProgramMatcher {
  public:
    // range: of the disparities to be expected; the program sees them counted from its least one on. threads:
    // for the project's own. Returns maps of the pair's size in its px; what has too little confidence is
    // unknown. Throws Error(input) if the program fails, answers too late or gives no map of the pair,
    // Error(output) if there is no place for the pictures.
    stages::ViewMaps match(const StereoPair& pair, const stages::DisparityConfig& range, int threads,
                           RunLog& log);

  private:
    struct Question;
    // is_dense: made false if the map lacks more than some pixels.
    DisparityMap answer(const StereoPair& pair, const std::string& view, const stages::DisparityConfig& range,
                        int threads, bool& is_dense, RunLog& log);
    // Returns what the worker tells of what it did.
    std::vector<std::string> ask_worker(const Question& question, const stages::DisparityConfig& range,
                                        int threads);

    std::vector<std::string> words_;  // of the worker that runs
    std::unique_ptr<ChildProgram> worker_;
};

}  // namespace hexrelief::job
