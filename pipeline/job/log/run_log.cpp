#include "pipeline/job/log/run_log.h"

#include <algorithm>

#include "pipeline/files/interrupt.h"

namespace hexrelief::job {

void RunLog::begin_stage(const std::string& name) const {
    files::wait_if_interrupted();
    if (stage_begins) stage_begins(name);
}

void RunLog::end_stage(const std::string& name, double seconds) {
    if (stage_ends) stage_ends(name, seconds);
    const auto known =
        std::ranges::find_if(stage_seconds_, [&](const auto& entry) { return entry.first == name; });
    if (known == stage_seconds_.end())
        stage_seconds_.emplace_back(name, seconds);
    else
        known->second += seconds;
}

void RunLog::progress(double share) const {
    files::wait_if_interrupted();
    if (stage_progresses) stage_progresses(share);
}

void RunLog::decide(const std::string& decision) const {
    if (decides) decides(decision);
}

void RunLog::warn(const std::string& warning) {
    warnings_.push_back(warning);
    if (warns) warns(warning);
}

}  // namespace hexrelief::job
