#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>

#include "exporters/viewer/html_exporter.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/config/options.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "samples/sample_pair.h"

extern char** environ;

namespace hexrelief::cli {
namespace {

namespace fs = std::filesystem;

struct DemoOptions {
    fs::path folder = "hexrelief-demo";
    bool stays_closed = false;
};

bool has_screen() {
    const auto is_set = [](const char* name) {
        const char* const value = std::getenv(name);
        return value != nullptr && *value != '\0';
    };
    return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
}

// Opens the page; false if no program is found for it.
bool open_page(const fs::path& page) {
    std::string program = "xdg-open", path = fs::absolute(page).string();
    char* const arguments[] = {program.data(), path.data(), nullptr};
    pid_t process = 0;
    int status = 0;
    return posix_spawnp(&process, program.c_str(), nullptr, nullptr, arguments, environ) == 0 &&
           waitpid(process, &status, 0) == process && status == 0;
}

bool holds(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
    std::ifstream stream(path, std::ios::binary);
    return stream && std::equal(bytes.begin(), bytes.end(), std::istreambuf_iterator<char>(stream), {},
                                [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); });
}

// Throws Error(output) if a file that the demo would write exists, unless the folder holds the demo's own
// pair, whose files are written anew.
void check_folder(const fs::path& folder, const std::vector<samples::SampleFile>& pair,
                  const std::vector<fs::path>& outputs) {
    files::check_writable_folder(folder);
    if (std::ranges::all_of(pair, [&](const auto& f) { return holds(folder / f.name, f.bytes); })) return;
    std::vector<fs::path> files;
    for (const samples::SampleFile& file : pair) files.push_back(folder / file.name);
    files.insert(files.end(), outputs.begin(), outputs.end());
    for (const fs::path& file : files)
        if (fs::exists(fs::symlink_status(file)))
            throw Error(ErrorKind::output,
                        file.string() + " is there already, and is not the demo's; choose another folder");
}

int show_demo(const DemoOptions& demo) {
    const fs::path& folder = demo.folder;
    const fs::path page = folder / "relief.html";
    std::vector<fs::path> outputs = {folder / "relief.glb"};
    if (exporters::has_viewer()) outputs.push_back(page);
    const std::vector<samples::SampleFile> pair = samples::sample_files();
    check_folder(folder, pair, outputs);
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure)
        throw Error(ErrorKind::output,
                    "cannot make the folder " + folder.string() + ": " + failure.message());
    samples::write_sample_files(pair, folder);
    FileRequest files{.left = folder / "left.png", .right = folder / "right.png"};
    const std::string calibration = folder / "calib.txt";
    files.outputs = {outputs.begin(), outputs.end()};
    std::vector<std::string> words = {"hexrelief", "run",       "--left",  files.left,
                                      "--right",   files.right, "--calib", calibration};
    for (const fs::path& output : outputs) words.insert(words.end(), {"-o", output.string()});
    std::printf("%s\n", printable(config::shell_line(words)).c_str());
    files.ends_process = true;
    end_on_interrupt();
    run_and_tell(files, {.direct = {{"--calib", calibration}}}, Verbosity::summary);
    if (!exporters::has_viewer())
        std::printf("%s\n", exporters::kNoViewer);
    else if (demo.stays_closed || !has_screen() || !open_page(page))
        std::printf("open %s in a browser to look at it\n", printable(page.string()).c_str());
    end_telling();
    return 0;
}

}  // namespace

void add_demo_command(Command& program) {
    Command command =
        program.add_command("demo", "writes a small stereo pair, makes a mesh of it and shows it");
    const auto options = std::make_shared<DemoOptions>();
    command.add_option("FOLDER", &options->folder,
                       "where all of it goes; hexrelief-demo where none is given");
    command.add_flag("--no-open", options->stays_closed, "write the page without opening it");
    command.set_footer(R"(Example:
  hexrelief demo)");
    command.set_action([options] { return show_demo(*options); });
}

}  // namespace hexrelief::cli
