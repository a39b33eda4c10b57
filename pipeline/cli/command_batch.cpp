#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <utility>

#include "pipeline/batch/batch.h"
#include "pipeline/batch/file_pattern.h"
#include "pipeline/batch/manifest.h"
#include "pipeline/batch/table.h"
#include "pipeline/batch/worker.h"
#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/config/options.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/library/conversions.h"

namespace hexrelief::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFooterHead =
    R"(What is to be done:
  pairs.csv           columns left,right or disparity or depth; color, calib, name, formats and other
                      options of 'hexrelief run', and keys of the configuration: mesh.spacing_px
  pairs.jsonl, .yaml  the same keys as an object a line, or as a list of rows with common 'defaults'
  DIR                 its pairs, and those in its folders, by the first of these rules that fits; with the
                      calibration beside them, where there is one:
)";

constexpr const char* kFooterTail =
    R"(  'DIR/{name}/left.*' pairs by other names: for the right view 'left' is replaced, or im0, image_2,
                      cam0, ...
  jobs.txt            the options of one 'hexrelief run' a line; "double quotes" hold spaces
File names in a manifest are taken from its folder. A row's files are OUT/NAME.glb and OUT/NAME.json, its
report, which says whether it is up to date: a second call does only what changed, and what failed. A line
of jobs.txt names its own files, and is up to date by its --report; without one it is done each time.
OUT/batch.csv and OUT/batch.json hold all figures and warnings of all rows.

Rows that cannot be understood end the batch before it begins; with --keep-going the others are done. A row
that fails later stops no other. The exit code is 0 if all are there, else that of the first that is not.

Examples:
  hexrelief batch pairs.csv -o out --format glb,drc --set mesh.spacing_px=4
  hexrelief batch 'scenes/{name}/left.png' -o out --shard 3/16
  hexrelief batch pairs.yaml -o out --print-commands | parallel)";

// Returns the command's page: the rules for folders stand in the middle.
std::string footer() {
    std::string text = kFooterHead;
    for (const batch::PairRule& rule : batch::pair_rules())
        text += std::string(24, ' ') + rule.files() + " (" + rule.name + ")\n";
    return text + kFooterTail;
}

job::RunRequest request_of_words(const std::vector<std::string>& words) {
    FileRequest files;
    Options options;
    Verbosity verbosity{};
    ArgumentParser parser("hexrelief run", "", {});
    Command command = parser.root();
    add_run_options(command, files, options, verbosity);
    std::string program = "hexrelief run";
    std::vector<std::string> copies = words;
    std::vector<char*> arguments{program.data()};
    for (std::string& word : copies) arguments.push_back(word.data());
    if (!parser.parse(static_cast<int>(arguments.size()), arguments.data()))
        throw Error(ErrorKind::usage, "a job takes neither --help nor --version");
    return library::request_of(files, options);
}

struct BatchCommand {
    fs::path what, output;
    Options rows;  // for all rows
    std::vector<std::string> formats;
    std::string gpus, shard, memory, log = "auto";
    int jobs = 0, threads = 0;
    bool keep_going = false, force = false, dry_run = false, print_commands = false, depfiles = false;
    bool quiet = false;
};

batch::ManifestOptions manifest_options(const BatchCommand& command) {
    batch::ManifestOptions options{command.output, {"glb"}, command.rows.config, {}, command.depfiles};
    if (!command.formats.empty()) options.formats = command.formats;
    if (command.print_commands && !options.output.empty())
        options.output = fs::absolute(options.output).lexically_normal();
    for (const auto& [key, text] : command.rows.settings)
        options.words.insert(options.words.end(), {"--set", key + "=" + text});
    // As settings, so that a row's own options override them.
    const std::vector<std::string> keys = config::keys_of_options(command.rows.direct, {});
    for (std::size_t i = 0; i < keys.size(); ++i)
        options.words.insert(options.words.end(), {"--set", keys[i] + "=" + command.rows.direct[i].second});
    for (const FileOption& file : file_options()) options.file_options.emplace_back(file.flag);
    return options;
}

std::vector<batch::BatchUnit> units_of(const BatchCommand& command, const Shard& shard) {
    const fs::path what = command.print_commands ? fs::absolute(command.what) : command.what;
    const std::vector<batch::BatchUnit> all = batch::read_manifest(what, manifest_options(command));
    std::vector<batch::BatchUnit> units;
    for (std::size_t i = shard.number - 1; i < all.size(); i += shard.of) units.push_back(all[i]);
    batch::check_units(units, request_of_words);
    const auto first = std::ranges::find_if(units, [](const auto& u) { return !u.wrong.empty(); });
    if (first == units.end() || command.keep_going) return units;
    const auto others =
        std::count_if(first + 1, units.end(), [](const auto& unit) { return !unit.wrong.empty(); });
    throw Error(first->kind, first->place + ": " + first->wrong +
                                 (others > 0 ? " (and " + std::to_string(others) + " more rows)" : ""));
}

bool has_word(const batch::BatchUnit& unit, const std::string& word) {
    return std::ranges::any_of(
        unit.words, [&](const std::string& other) { return other == word || other.starts_with(word + "="); });
}

void print_failure(const batch::BatchUnit& unit, const std::string& message) {
    std::fprintf(stderr, "hexrelief: %s\n", printable(unit.place + ": " + message).c_str());
}

int print_commands(const BatchCommand& command, const std::vector<batch::BatchUnit>& units) {
    int code = 0;
    for (const batch::BatchUnit& unit : units) {
        if (!unit.wrong.empty()) {
            print_failure(unit, unit.wrong);
            code = code == 0 ? static_cast<int>(unit.kind) : code;
            continue;
        }
        std::vector<std::string> words = {"hexrelief", "run"};
        if (!command.force && has_word(unit, "--report") && !has_word(unit, "--update"))
            words.emplace_back("--update");
        words.insert(words.end(), unit.words.begin(), unit.words.end());
        // The lines of jobs.txt belong to this folder.
        const bool of_folder = unit.name == unit.place;
        std::printf("%s%s\n",
                    of_folder ? ("cd " + config::shell_quoted(fs::current_path()) + " && ").c_str() : "",
                    config::shell_line(words).c_str());
    }
    return code;
}

// Prints each warning once, with the first row that has it and the number of the others.
void print_warnings(const std::vector<batch::BatchUnit>& units,
                    const std::vector<batch::UnitResult>& results) {
    std::map<std::string, std::size_t> rows;
    for (const batch::UnitResult& result : results)
        for (const std::string& warning : result.warnings) ++rows[warning];
    for (std::size_t i = 0; i < units.size(); ++i)
        for (const std::string& warning : results[i].warnings)
            if (const std::size_t count = std::exchange(rows[warning], 0))
                print_warning(units[i].place +
                              (count > 1 ? " (and " + std::to_string(count - 1) + " more rows): " : ": ") +
                              warning);
}

class BatchTeller {
  public:
    BatchTeller(const BatchCommand& command, const std::vector<batch::BatchUnit>& units)
        : units_(units),
          dry_run_(command.dry_run),
          is_quiet_(command.quiet),
          as_json_(command.log == "jsonl" || (command.log == "auto" && !isatty(STDOUT_FILENO))),
          has_bar_(!is_quiet_ && isatty(STDERR_FILENO)) {
        counts_.units = units.size();
        if (as_json_ && !is_quiet_) print(batch::start_event(counts_));
    }

    void unit_ended(std::size_t unit, const batch::UnitResult& result) {
        counts_.add(result.outcome);
        if (is_quiet_) return;
        if (as_json_) {
            print(batch::unit_event(units_[unit], result, counts_));
        } else if (dry_run_ && result.outcome != batch::UnitOutcome::failed) {
            const bool current = result.outcome == batch::UnitOutcome::up_to_date;
            const std::string& rule = units_[unit].rule;
            print(printable(units_[unit].name + ": " + (current ? "up to date" : "to do, " + result.message) +
                            (rule.empty() ? "" : "; found as " + rule)) +
                  "\n");
        }
        draw();
    }

    void draw() {
        if (has_bar_) std::fprintf(stderr, "\r%s\x1b[K", batch::progress_bar(counts_, seconds()).c_str());
    }

    void batch_ended(const batch::BatchResult& result) {
        clear_bar();
        for (std::size_t i = 0; i < units_.size() && !result.interrupted; ++i)
            if (result.units[i].outcome == batch::UnitOutcome::failed)
                print_failure(units_[i], result.units[i].message);
        if (is_quiet_) return;
        if (!result.interrupted) print_warnings(units_, result.units);
        print(as_json_ ? batch::end_event(counts_, seconds()) : batch::batch_summary(counts_, seconds()));
    }

  private:
    double seconds() const { return now_seconds() - begun_; }
    void clear_bar() {
        if (has_bar_) std::fputs("\r\x1b[K", stderr);
    }
    void print(const std::string& text) {
        clear_bar();
        std::fputs(text.c_str(), stdout);
        if (!dry_run_) end_telling();
    }

    const std::vector<batch::BatchUnit>& units_;
    bool dry_run_, is_quiet_, as_json_, has_bar_;
    batch::BatchCounts counts_;
    double begun_ = now_seconds();
};

struct TableFiles {
    fs::path csv, json;
};
TableFiles table_files(const fs::path& folder, const Shard& shard) {
    const std::string part =
        shard.of == 1 ? "" : "-" + std::to_string(shard.number) + "-of-" + std::to_string(shard.of);
    return {folder / ("batch" + part + ".csv"), folder / ("batch" + part + ".json")};
}

void write_table(const TableFiles& table, const std::vector<batch::BatchUnit>& units,
                 const batch::BatchResult& result) {
    std::vector<batch::TableRow> rows;
    for (std::size_t i = 0; i < units.size(); ++i) {
        batch::TableRow row{units[i].name, units[i].place, result.units[i], {}};
        if (units[i].wrong.empty()) row.report = request_of_words(units[i].words).report;
        rows.push_back(std::move(row));
    }
    files::OutputSet files;
    files.write(table.csv, batch::table_csv(rows));
    files.write(table.json, batch::table_json(rows));
    files.commit();
}

int run_batch(const BatchCommand& command) {
    if (command.log != "auto" && command.log != "jsonl" && command.log != "text")
        throw Error(ErrorKind::usage, "--log: must be auto, text or jsonl, not '" + command.log + "'");
    const Shard shard = parse_shard(command.shard);
    batch::BatchSettings settings;
    settings.rules = {request_of_words, command.force, command.dry_run};
    settings.workers = command.jobs;
    settings.threads = command.threads;
    settings.memory = parse_memory(command.memory);
    const std::vector<batch::BatchUnit> units = units_of(command, shard);
    if (command.print_commands) return print_commands(command, units);
    settings.devices = batch::devices_of(command.gpus);
    const bool writes_table = !command.output.empty() && !command.dry_run;
    const TableFiles table = table_files(command.output, shard);
    if (writes_table) {
        files::check_writable_folder(command.output);
        std::vector<fs::path> read(command.rows.config.begin(), command.rows.config.end());
        read.emplace_back(command.what);
        files::check_overwrites({table.csv, table.json}, read);
    }

    BatchTeller teller(command, units);
    const batch::BatchResult result = batch::run_units(
        units, settings,
        {[&](std::size_t unit, const batch::UnitResult& ended) { teller.unit_ended(unit, ended); },
         [&] { teller.draw(); }});
    teller.batch_ended(result);
    if (result.interrupted) return files::kInterruptedExitCode;
    if (writes_table) write_table(table, units, result);
    const auto failed =
        std::ranges::find(result.units, batch::UnitOutcome::failed, &batch::UnitResult::outcome);
    return failed == result.units.end() ? 0 : std::max(1, failed->exit_code);
}

void add_batch_options(Command& command, BatchCommand& options) {
    command.add_option("what", &options.what, "manifest, folder, pattern with {name}, or lines of options",
                       {.value = "MANIFEST|DIR", .required = true});
    command.add_option("-o,--output", &options.output, "folder of all outputs, and of the table",
                       {.value = "OUT"});
    command.add_option("--format", &options.formats, "of rows that name none: glb, drc, obj, ...",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--jobs", &options.jobs, "rows at a time; 0 = one a thread, or one a device",
                       {.value = "N", .range = {{0, 1024}}});
    command.add_option("--threads", &options.threads, "of all rows together; 0 = all",
                       {.value = "N", .range = {{0, 4096}}});
    command.add_option("--gpus", &options.gpus, "all, or a number: the rows are spread over these devices",
                       {.value = "all|N"});
    command.add_option("--memory", &options.memory,
                       "for all rows together, as 8G; otherwise three quarters of what is free",
                       {.value = "SIZE"});
    command.add_option("--shard", &options.shard, "every N-th row from row K on", {.value = "K/N"});
    command.add_flag("--keep-going", options.keep_going, "rows that cannot be understood fail by themselves");
    command.add_flag("--force", options.force, "do what is up to date as well");
    command.add_flag("--dry-run", options.dry_run, "tell what would be done, and why; write nothing");
    command.add_flag("--print-commands", options.print_commands,
                     "print a command a row, for a shell or a cluster; do nothing");
    command.add_flag("--depfile", options.depfiles, "OUT/NAME.d: a rule for make with what the row reads");
    command.add_option("--log", &options.log, "jsonl: an object a line; auto: text on a terminal, else jsonl",
                       {.value = "auto|text|jsonl", .shows_default = true});
    command.add_flag("--quiet", options.quiet, "nothing but failures");
    const char* const group = "Rows";
    add_config_options(command, options.rows, group);
    std::vector<std::string> flags = config::option_flags("Job");
    std::erase(flags, "--threads");  // applies to all rows together, see above
    add_key_options(command, options.rows, flags, group);
}

}  // namespace

void add_batch_command(Command& program) {
    Command command = program.add_command("batch", "many pairs or maps: what changed, several at a time");
    const auto options = std::make_shared<BatchCommand>();
    add_batch_options(command, *options);
    command.set_footer(footer());
    command.set_action([options] { return run_batch(*options); });
}

}  // namespace hexrelief::cli
