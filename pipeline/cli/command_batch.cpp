#include <cstdio>
#include <fstream>
#include <iomanip>
#include <memory>
#include <sstream>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

constexpr const char* kFooter =
    R"(Each line of the file holds the options of one 'hexrelief run'. Empty lines and
those that begin with # are skipped; "double quotes" hold spaces. All lines are checked before the first job.
The first job that fails ends the batch; what the jobs before it have written stays.

Example, jobs.txt:
  --left a_left.png --right a_right.png -o a.glb
  --disparity "map of b.pfm" --color b.png -o b.drc --set mesh.spacing_px=4)";

struct BatchJob {
    RunOptions options;
};

[[noreturn]] void fail(const std::string& where, const Error& error) {
    throw Error(error.kind(), where + ": " + error.what());
}

std::vector<std::string> words_of(const std::string& line) {
    std::istringstream text(line);
    std::vector<std::string> words;
    for (std::string word; text >> std::quoted(word, '"', '\0');) words.push_back(word);
    return words;
}

// Nothing where the line has no job.
std::unique_ptr<BatchJob> parse_job(const std::string& line) {
    std::vector<std::string> words = words_of(line);
    if (words.empty() || words.front().starts_with('#')) return nullptr;
    auto job = std::make_unique<BatchJob>();
    ArgumentParser parser("hexrelief run", "", {});
    Command command = parser.root();
    add_run_options(command, job->options);
    std::string program = "hexrelief run";
    std::vector<char*> arguments{program.data()};
    for (std::string& word : words) arguments.push_back(word.data());
    if (!parser.parse(static_cast<int>(arguments.size()), arguments.data()))
        throw Error(ErrorKind::usage, "a job takes neither --help nor --version");
    check_run(job->options);
    if (uses_standard_output(job->options.request))
        throw Error(ErrorKind::usage, "a job of a batch cannot write to the standard output; name a file");
    return job;
}

std::vector<std::unique_ptr<BatchJob>> read_jobs(const std::filesystem::path& path,
                                                 std::vector<std::string>& places) {
    std::ifstream file(path);
    if (!file) throw Error(ErrorKind::input, "cannot read the jobs of '" + path.string() + "'");
    std::vector<std::unique_ptr<BatchJob>> jobs;
    int number = 0;
    for (std::string line; std::getline(file, line);) {
        const std::string place = path.string() + ":" + std::to_string(++number);
        try {
            if (auto job = parse_job(line)) {
                jobs.push_back(std::move(job));
                places.push_back(place);
            }
        } catch (const Error& error) {
            fail(place, error);
        }
    }
    if (jobs.empty()) throw Error(ErrorKind::input, path.string() + " holds no job");
    return jobs;
}

int run_batch(const std::filesystem::path& path, bool strict) {
    std::vector<std::string> places;
    const std::vector<std::unique_ptr<BatchJob>> jobs = read_jobs(path, places);
    end_on_interrupt();
    const double begun = now_seconds();
    bool quiet = true;
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        jobs[i]->options.request.runs = static_cast<int>(jobs.size());
        if (strict) jobs[i]->options.strict = true;
        quiet = quiet && jobs[i]->options.quiet;
        try {
            run_and_tell(jobs[i]->options);
        } catch (const Error& error) {
            fail(places[i], error);
        }
    }
    const double seconds = now_seconds() - begun;
    if (!quiet)
        std::printf("%zu jobs, %.2f s, %.1f a second\n", jobs.size(), seconds,
                    static_cast<double>(jobs.size()) / seconds);
    return 0;
}

}  // namespace

void add_batch_command(Command& program) {
    Command command = program.add_command("batch", "many runs in one process, which starts the device once");
    const auto path = std::make_shared<std::filesystem::path>();
    command.add_option("jobs", path.get(), "text file with the options of one run a line",
                       {.value = "FILE", .required = true});
    const auto strict = std::make_shared<bool>(false);
    command.add_flag("--strict", *strict, "as --strict on every line");
    command.set_footer(kFooter);
    command.set_action([path, strict] { return run_batch(*path, *strict); });
}

}  // namespace hexrelief
