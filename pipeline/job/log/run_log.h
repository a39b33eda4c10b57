// Messages of a running job: its stages, decisions and warnings.
#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipeline/data/clock.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::job {

// Reports each event at once, and keeps times and warnings for the report. stage() and progress() end the
// process if the run has been interrupted (interrupt.h).
class RunLog {
  public:
    RunLog() = default;
    RunLog(const RunLog&) = delete;
    RunLog& operator=(const RunLog&) = delete;

    // Callbacks for the events; each may be empty.
    std::function<void(const std::string& stage)> stage_begins;
    std::function<void(double share)> stage_progresses;
    std::function<void(const std::string& stage, double seconds)> stage_ends;
    std::function<void(const std::string& decision)> decides;
    std::function<void(const std::string& warning)> warns;

    // Runs one stage and returns the result of `work`. Times of stages with the same name are added up: a
    // budget repeats a stage several times.
    template <typename Work>
    auto stage(const std::string& name, const Work& work) {
        begin_stage(name);
        const double begun = now_seconds();
        if constexpr (std::is_void_v<decltype(work())>) {
            work();
            end_stage(name, now_seconds() - begun);
        } else {
            auto result = work();
            end_stage(name, now_seconds() - begun);
            return result;
        }
    }
    void progress(double share) const;  // of the current stage, 0..1
    void decide(const std::string& decision) const;
    void warn(const std::string& warning);

    const std::vector<std::pair<std::string, double>>& stage_seconds() const { return stage_seconds_; }
    double seconds() const { return now_seconds() - begun_; }  // since this log was made
    const std::vector<std::string>& warnings() const { return warnings_; }

  private:
    void begin_stage(const std::string& name) const;
    void end_stage(const std::string& name, double seconds);

    const double begun_ = now_seconds();
    std::vector<std::pair<std::string, double>> stage_seconds_;  // in the order of their first end
    std::vector<std::string> warnings_;
};

}  // namespace hexrelief::job
