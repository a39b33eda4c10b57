#include "pipeline/batch/batch.h"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <optional>
#include <system_error>

#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/run_files.h"

namespace hexrelief::batch {
namespace {

constexpr int kWait_ms = 200;

// Makes Ctrl-C and termination readable from a socket; the destructor restores the previous signal mask.
class SignalSocket {
  public:
    SignalSocket() {
        sigset_t awaited;
        sigemptyset(&awaited);
        for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&awaited, number);
        pthread_sigmask(SIG_BLOCK, &awaited, &before_);
        socket_ = ::signalfd(-1, &awaited, SFD_CLOEXEC);
    }
    SignalSocket(const SignalSocket&) = delete;
    SignalSocket& operator=(const SignalSocket&) = delete;
    ~SignalSocket() {
        if (socket_ >= 0) ::close(socket_);
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    int socket() const { return socket_; }
    // Takes the signal that has come, which would otherwise end the process when it is unblocked again.
    bool take() const {
        signalfd_siginfo signal{};
        return ::read(socket_, &signal, sizeof signal) > 0;
    }

  private:
    sigset_t before_;
    int socket_;
};

class Scheduler {
  public:
    Scheduler(const std::vector<BatchUnit>& units, const BatchSettings& settings,
              const BatchObserver& observer)
        : units_(units),
          settings_(settings),
          observer_(observer),
          rules_(settings.rules),
          memory_(settings.memory > 0 ? settings.memory : memory_to_use()),
          estimates_(units.size()) {
        result_.units.resize(units.size());
        const int threads = job::effective_threads(settings.threads);
        const auto devices = static_cast<int>(settings.devices.size());
        const int wanted = settings.workers > 0 ? settings.workers : devices > 0 ? devices : threads;
        most_workers_ = std::max(1, std::min(wanted, static_cast<int>(units.size())));
        rules_.threads = std::max(1, threads / most_workers_);
        rules_.jobs = std::max(1, static_cast<int>(units.size()) / most_workers_);
    }

    BatchResult run() {
        fail_wrong_units();
        while (!result_.interrupted && (hand_out() || is_any_busy())) wait();
        if (result_.interrupted) stop();
        return std::move(result_);
    }

  private:
    void end(std::size_t unit, UnitResult result) {
        result_.units[unit] = std::move(result);
        if (observer_.ended) observer_.ended(unit, result_.units[unit]);
    }

    void fail_wrong_units() {
        for (std::size_t i = 0; i < units_.size(); ++i)
            if (!units_[i].wrong.empty())
                end(i, {UnitOutcome::failed, 0, 0, static_cast<int>(units_[i].kind), units_[i].wrong});
    }

    bool is_any_busy() const {
        return std::ranges::any_of(workers_, [](const Worker& w) { return w.is_busy(); });
    }

    std::optional<std::size_t> next_unit() {
        while (next_ < units_.size() && !units_[next_].wrong.empty()) ++next_;
        return next_ < units_.size() ? std::optional(next_) : std::nullopt;
    }

    std::uint64_t estimate(std::size_t unit) {
        if (estimates_[unit] == 0) {
            try {
                estimates_[unit] = job::estimated_memory(rules_.parse(units_[unit].words));
            } catch (...) {  // it will fail as soon as it begins
                estimates_[unit] = 1;
            }
        }
        return estimates_[unit];
    }

    std::uint64_t in_use() const {
        std::uint64_t bytes = 0;
        for (const Worker& worker : workers_)
            if (worker.is_busy()) bytes += memory_.expected(estimates_[worker.unit()]);
        return bytes;
    }

    // Gives units to idle workers as long as memory allows. True if one was begun.
    bool hand_out() {
        bool begun = false;
        while (const auto unit = next_unit()) {
            if (!memory_.fits(memory_.expected(estimate(*unit)), in_use())) break;
            Worker* const worker = idle_worker();
            if (worker == nullptr) break;
            if (!worker->start(*unit)) {  // killed while it was idle
                worker->finish();
                remove_dead();
                continue;
            }
            ++next_;
            begun = true;
        }
        return begun;
    }

    // Returns an idle worker, or nullptr if all are busy and no more may, or can, be started.
    Worker* idle_worker() {
        for (Worker& worker : workers_)
            if (!worker.is_busy()) return &worker;
        if (static_cast<int>(workers_.size()) >= most_workers_) return nullptr;
        try {
            std::vector<int> sockets = {signals_.socket()};
            for (const Worker& worker : workers_) sockets.push_back(worker.socket());
            return &workers_.emplace_back(units_, rules_, next_device(), sockets);
        } catch (const std::system_error&) {
            if (workers_.empty()) throw;
            most_workers_ = static_cast<int>(workers_.size());
            return nullptr;
        }
    }

    std::string next_device() {
        if (settings_.devices.empty()) return {};
        return settings_.devices[forked_++ % settings_.devices.size()];
    }

    void wait() {
        std::vector<pollfd> sockets = {{signals_.socket(), POLLIN, 0}};
        for (const Worker& worker : workers_) sockets.push_back({worker.socket(), POLLIN, 0});
        if (::poll(sockets.data(), sockets.size(), kWait_ms) > 0) {
            result_.interrupted = sockets[0].revents != 0 && signals_.take();
            for (std::size_t i = 0; i < workers_.size() && !result_.interrupted; ++i)
                if (sockets[i + 1].revents != 0) take_result(workers_[i]);
            remove_dead();
        }
        if (observer_.waits) observer_.waits();
    }

    void take_result(Worker& worker) {
        if (!worker.is_busy()) {  // the worker has ended
            worker.finish();
            return;
        }
        const std::size_t unit = worker.unit();
        UnitResult result = worker.finish();
        if (result.peak_bytes > 0) memory_.learn(estimates_[unit], result.peak_bytes);
        end(unit, std::move(result));
    }

    void remove_dead() {
        std::vector<Worker> living;
        for (Worker& worker : workers_)
            if (!worker.is_dead()) living.push_back(std::move(worker));
        workers_.swap(living);
    }

    // Ends all workers, which undo their unfinished outputs.
    void stop() {
        for (const Worker& worker : workers_) worker.terminate();
        for (Worker& worker : workers_)
            if (worker.is_busy()) {
                const std::size_t unit = worker.unit();
                result_.units[unit] = worker.finish();
            }
        for (std::size_t i = next_; i < units_.size(); ++i) {
            result_.units[i].exit_code = files::kInterruptedExitCode;
            result_.units[i].message = "interrupted";
        }
        workers_.clear();
    }

    const std::vector<BatchUnit>& units_;
    const BatchSettings& settings_;
    const BatchObserver& observer_;
    UnitRules rules_;
    MemoryRule memory_;
    std::vector<std::uint64_t> estimates_;  // 0 = not known yet
    SignalSocket signals_;
    std::vector<Worker> workers_;
    BatchResult result_;
    int most_workers_ = 1;
    std::size_t next_ = 0, forked_ = 0;
};

namespace fs = std::filesystem;

struct FileUser {
    std::size_t unit;
    bool is_written;
};

// Returns a path's plain name. Links are not followed, because a batch has some ten paths per row.
fs::path plain_name(const fs::path& path) {
    return fs::absolute(path).lexically_normal();
}

class Collisions {
  public:
    explicit Collisions(const std::vector<BatchUnit>& units) : units_(units) {}

    // Returns why the unit must not run beside those before it; empty if it may.
    std::string add(std::size_t unit, const job::RunRequest& request) {
        for (const job::WrittenFile& file : job::written_files(request))
            if (std::string why = use(file.path, {unit, true}); !why.empty()) return why;
        for (const fs::path& file : job::read_files(request))
            if (std::string why = use(file, {unit, false}); !why.empty()) return why;
        return {};
    }

  private:
    std::string use(const fs::path& file, const FileUser& user) {
        const auto [known, is_new] = users_.try_emplace(plain_name(file), user);
        if (is_new || known->second.unit == user.unit) return {};
        FileUser& other = known->second;
        const std::string& place = units_[other.unit].place;
        if (user.is_written && other.is_written)
            return file.string() + " is an output of " + place + ", too; choose another name";
        if (user.is_written || other.is_written)
            return file.string() + " is an input of one row and an output of another, " + place +
                   "; rows are done in any order";
        return {};
    }

    const std::vector<BatchUnit>& units_;
    std::map<fs::path, FileUser> users_;
};

}  // namespace

BatchResult run_units(const std::vector<BatchUnit>& units, const BatchSettings& settings,
                      const BatchObserver& observer) {
    return Scheduler(units, settings, observer).run();
}

void check_units(std::vector<BatchUnit>& units, const RequestParser& parse) {
    Collisions collisions(units);
    for (std::size_t i = 0; i < units.size(); ++i) {
        BatchUnit& unit = units[i];
        if (!unit.wrong.empty()) continue;
        try {
            const job::RunRequest request = parse(unit.words);
            job::check_request(request);
            if (job::writes_standard_output(request))
                throw Error(ErrorKind::usage,
                            "a job of a batch cannot write to the standard output; name a file");
            unit.wrong = collisions.add(i, request);
        } catch (const Error& error) {
            unit.wrong = error.what();
            unit.kind = error.kind();
        }
    }
}

}  // namespace hexrelief::batch
