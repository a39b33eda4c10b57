#include "pipeline/batch/unit.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>

#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/job/run_files.h"
#include "pipeline/job/runner.h"
#include "pipeline/job/stamp/stamp.h"

namespace hexrelief::batch {
namespace {

constexpr int kBug = 1, kMemory = 6;
constexpr const char* kOutOfMemory =
    "out of memory; close other programs, or use smaller pictures or a larger mesh.spacing_px";

// Resets the process's peak memory. On kernels that cannot, it remains the peak so far.
void forget_peak_memory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

std::size_t peak_memory() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == "VmHWM:") {
            std::size_t kib = 0;
            status >> kib;
            return kib * 1024;
        }
    return 0;
}

UnitResult attempt(const BatchUnit& unit, const UnitRules& rules, job::Backends& backends, job::RunLog& log) {
    UnitResult result;
    job::RunRequest request = rules.parse(unit.words);
    if (request.config.run.threads == 0) request.config.run.threads = rules.threads;
    request.jobs = rules.jobs;
    const job::UnitState state = job::stamp_request(request);
    if (!rules.force && state == job::UnitState::current) {
        result.outcome = UnitOutcome::up_to_date;
    } else if (rules.dry_run) {
        result.outcome = UnitOutcome::would_run;
        result.message = state == job::UnitState::missing ? "no result yet"
                         : state == job::UnitState::changed
                             ? "its inputs, configuration, version or outputs changed"
                             : "up to date, but --force is given";
    } else {
        job::run_job(request, backends, log);
        result.outcome = UnitOutcome::done;
    }
    return result;
}

}  // namespace

std::string outcome_name(UnitOutcome outcome) {
    constexpr const char* kNames[] = {"done", "up_to_date", "would_run", "failed"};
    return kNames[static_cast<std::size_t>(outcome)];
}

UnitResult result_of_exception() {
    UnitResult result;
    result.outcome = UnitOutcome::failed;
    result.exit_code = kBug;
    try {
        throw;
    } catch (const Error& error) {
        result.exit_code = static_cast<int>(error.kind());
        result.message = error.what();
    } catch (const std::filesystem::filesystem_error& error) {  // a file that vanished or is inaccessible
        result.exit_code = static_cast<int>(ErrorKind::input);
        result.message = "cannot use '" + error.path1().string() + "': " + error.code().message();
    } catch (const std::bad_alloc&) {
        result.exit_code = kMemory;
        result.message = kOutOfMemory;
    } catch (const std::system_error& error) {  // thrown by threads, which need memory
        const bool memory = error.code() == std::errc::resource_unavailable_try_again;
        result.exit_code = memory ? kMemory : kBug;
        result.message = memory ? kOutOfMemory : std::string("internal error: ") + error.what();
    } catch (const std::exception& error) {
        result.message = std::string("internal error: ") + error.what();
    } catch (...) {
        result.message = "internal error: unknown exception";
    }
    std::replace(result.message.begin(), result.message.end(), '\n', ' ');
    return result;
}

UnitResult do_unit(const BatchUnit& unit, const UnitRules& rules, job::Backends& backends) {
    forget_peak_memory();
    const double begun = now_seconds();
    UnitResult result;
    job::RunLog log;
    try {
        result = attempt(unit, rules, backends, log);
    } catch (...) {
        result = result_of_exception();
    }
    result.warnings = log.warnings();
    result.seconds = now_seconds() - begun;
    result.peak_bytes = peak_memory();
    return result;
}

}  // namespace hexrelief::batch
