#include <cstdio>
#include <memory>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/gallery/gallery.h"
#include "pipeline/cli/printable.h"

namespace hexrelief::cli {

void add_gallery_command(Command& program) {
    struct Options {
        std::filesystem::path folder, output;
    };
    Command command = program.add_command("gallery", "one page that lists the results in a folder");
    const auto options = std::make_shared<Options>();
    command.add_option("DIR", &options->folder,
                       "folder with pages (.html) and reports (.json), also below it", {.required = true});
    command.add_option("-o,--output", &options->output, "the page; index.html in that folder where not given",
                       {.value = "PAGE.html"});
    command.set_footer(
        R"(Each result has a thumbnail and its figures, by which the list is sorted, and is a click away.

Example:
  hexrelief run --left l.png --right r.png -o out/a.html --report out/a.json
  hexrelief gallery out)");
    command.set_action([options] {
        const auto path = options->output.empty() ? options->folder / "index.html" : options->output;
        const std::size_t results = write_gallery(options->folder, path);
        std::printf("%s lists %zu result%s\n", printable(path.string()).c_str(), results,
                    results == 1 ? "" : "s");
        end_telling();
        return 0;
    });
}

}  // namespace hexrelief::cli
