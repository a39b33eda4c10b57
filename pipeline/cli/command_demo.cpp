#include <spawn.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "exporters/viewer/html_exporter.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "samples/scene_files.h"

extern char** environ;

namespace hexrelief {
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

// False where there is nothing that opens it.
bool open_page(const fs::path& page) {
    std::string program = "xdg-open", path = fs::absolute(page).string();
    char* const arguments[] = {program.data(), path.data(), nullptr};
    pid_t process = 0;
    int status = 0;
    return posix_spawnp(&process, program.c_str(), nullptr, nullptr, arguments, environ) == 0 &&
           waitpid(process, &status, 0) == process && status == 0;
}

int show_demo(const DemoOptions& demo) {
    const fs::path& folder = demo.folder;
    check_writable_folder(folder);
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure)
        throw Error(ErrorKind::output,
                    "cannot make the folder " + folder.string() + ": " + failure.message());
    write_sample_files(folder);
    RunOptions options;
    options.request.left = folder / "left.png";
    options.request.right = folder / "right.png";
    options.calibration = folder / "calib.txt";
    options.request.outputs = {folder / "relief.glb"};
    const fs::path page = folder / "relief.html";
    if (has_viewer()) options.request.outputs.push_back(page);
    std::printf("hexrelief run --left %s --right %s --calib %s", options.request.left.c_str(),
                options.request.right.c_str(), options.calibration.c_str());
    for (const std::string& output : options.request.outputs) std::printf(" -o %s", output.c_str());
    std::printf("\n");
    options.request.ends_process = true;
    end_on_interrupt();
    run_and_tell(options);
    if (!has_viewer())
        std::printf("%s\n", kNoViewer);
    else if (demo.stays_closed || !has_screen() || !open_page(page))
        std::printf("open %s in a browser to look at it\n", page.c_str());
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
    command.set_footer("Example:\n  hexrelief demo");
    command.set_action([options] { return show_demo(*options); });
}

}  // namespace hexrelief
