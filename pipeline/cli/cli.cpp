#include "pipeline/cli/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <new>

#include "pipeline/cli/command_bench.h"
#include "pipeline/cli/commands.h"
#include "pipeline/job/interrupt.h"
#include "pipeline/config/suggest.h"
#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

constexpr int kUsageExitCode = static_cast<int>(ErrorKind::usage);
constexpr int kBugExitCode = 1;

int complain(const std::string& message, int code) {
    wait_if_interrupted();  // an interrupt makes writes fail; that is no error to tell
    std::string text = message;
    std::replace(text.begin(), text.end(), '\n', ' ');
    std::fprintf(stderr, "hexrelief: %s\n", text.c_str());
    return code;
}

// The innermost command that was named, and its full name.
const CLI::App& innermost(const CLI::App& app, std::string& name) {
    name += (name.empty() ? "" : " ") + app.get_name();
    for (const CLI::App* sub : app.get_subcommands()) return innermost(*sub, name);
    return app;
}

// " (did you mean '--left'?)" for the first argument that no option or command answers to.
std::string suggest_argument(const CLI::App& app, int argc, char** argv) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(sub->get_name());
    for (int i = 1; i < argc; ++i) {
        std::string argument = argv[i];
        argument.resize(std::min(argument.size(), argument.find('=')));
        if (std::find(names.begin(), names.end(), argument) != names.end()) continue;
        const bool option = argument.starts_with("--");
        if (!option && i + 1 < argc) continue;  // a value, most likely
        const std::string near = nearest_name(argument, names);
        if (!near.empty() && near.starts_with("--") == option) return " (did you mean '" + near + "'?)";
    }
    return {};
}

int complain_usage(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
    std::string name;
    const CLI::App& command = innermost(app, name);
    const std::string hint =
        dynamic_cast<const CLI::ExtrasError*>(&error) || dynamic_cast<const CLI::RequiredError*>(&error)
            ? suggest_argument(command, argc, argv)
            : "";
    return complain(std::string(error.what()) + hint + "; see '" + name + " --help'", kUsageExitCode);
}

}  // namespace

int run_command_line(int argc, char** argv) {
    try {
        CLI::App app("Stereo pairs and disparity maps to compact, textured, metric 3D meshes.", "hexrelief");
        app.set_version_flag("--version", "hexrelief " HEXRELIEF_VERSION, "print the version and exit");
        app.require_subcommand(1);
        app.footer(
            "Examples:\n"
            "  hexrelief run --left left.png --right right.png --calib calib.txt -o relief.glb\n"
            "  hexrelief run --disparity disp.png --disparity-scale 4 --color left.png -o relief.obj\n"
            "  hexrelief info relief.glb\n"
            "  hexrelief run --help");
        Action chosen;
        add_run_command(app, chosen);
        add_config_command(app, chosen);
        add_info_command(app, chosen);
        add_evaluate_command(app, chosen);
        add_devices_command(app, chosen);
        add_bench_command(app, chosen);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& e) {
            if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
            return complain_usage(app, e, argc, argv);
        }
        const int code = chosen();
        if (std::fflush(stdout) != 0 || std::ferror(stdout))
            throw Error(ErrorKind::output, "cannot write to standard output");
        return code;
    } catch (const Error& e) {
        return complain(e.what(), static_cast<int>(e.kind()));
    } catch (const std::bad_alloc&) {
        return complain("internal error: out of memory", kBugExitCode);
    } catch (const std::exception& e) {
        return complain(std::string("internal error: ") + e.what(), kBugExitCode);
    } catch (...) {
        return complain("internal error: unknown exception", kBugExitCode);
    }
}

}  // namespace hexrelief
