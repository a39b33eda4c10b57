#include <cstdio>
#include <memory>

#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"
#include "pipeline/config/document.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/library/conversions.h"

namespace hexrelief::cli {
namespace {

struct ConfigCommandOptions {
    Options shown;
    std::string checked;
    bool markdown = false;
};

int show(const ConfigCommandOptions& options) {
    const config::Config config = library::config_of(options.shown, {});
    const std::string text = options.markdown ? config::config_markdown() : config::config_yaml(config);
    std::fputs(text.c_str(), stdout);
    return 0;
}

int check(const ConfigCommandOptions& options) {
    const std::vector<std::string> mistakes = config::mistakes_in(options.checked);
    for (std::size_t i = 0; i + 1 < mistakes.size(); ++i) print_error(mistakes[i]);
    if (!mistakes.empty()) throw Error(ErrorKind::usage, mistakes.back());
    std::printf("%s: valid\n", printable(options.checked).c_str());
    return 0;
}

int schema() {
    std::fputs(config::config_schema().c_str(), stdout);
    return 0;
}

}  // namespace

void add_config_command(Command& program) {
    Command group = program.add_command("config", "show or check a configuration, or print its JSON Schema");
    group.set_footer(R"(Examples:
  hexrelief config show > my.yaml
  hexrelief config show --config my.yaml --set mesh.spacing_px=4
  hexrelief config check my.yaml
  hexrelief config schema > hexrelief.schema.json)");
    const auto options = std::make_shared<ConfigCommandOptions>();

    Command shown = group.add_command(
        "show", "the configuration as fully commented YAML, without options the default one");
    add_config_options(shown, options->shown, "Options");
    shown.add_flag("--markdown", options->markdown, "a table of all keys and their defaults, for documents");
    shown.set_footer(R"(Examples:
  hexrelief config show > my.yaml
  hexrelief config show --config my.yaml --set mesh.seed=7)");
    shown.set_action([options] { return show(*options); });

    Command checked = group.add_command("check", "check a YAML file: unknown keys, types, ranges");
    checked.add_option("FILE", &options->checked, "YAML file", {.required = true});
    checked.set_footer(R"(Example:
  hexrelief config check my.yaml)");
    checked.set_action([options] { return check(*options); });

    Command printed = group.add_command("schema", "a JSON Schema (draft 2020-12) for editors");
    printed.set_footer(R"(Example:
  hexrelief config schema > hexrelief.schema.json
  # first line of a YAML file, for editors: # yaml-language-server: $schema=hexrelief.schema.json)");
    printed.set_action([] { return schema(); });
}

}  // namespace hexrelief::cli
