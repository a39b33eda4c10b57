#include "pipeline/cli/cli.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>

#include "hexrelief_build_info.h"  // made by pipeline/cli/build_info.cmake
#include "pipeline/cli/commands.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/tiles/command_tiles.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"

namespace hexrelief::cli {
namespace {

// Returns "hexrelief 0.2.0"; if verbose, also lines with commit, compiler, CUDA and libraries.
std::string version_text(bool verbose) {
    const std::string version = "hexrelief " HEXRELIEF_VERSION;
    if (!verbose) return version;
    return version + "\ncommit     " HEXRELIEF_COMMIT "\nbuild      " HEXRELIEF_BUILD
                     "\nCUDA       " HEXRELIEF_CUDA_BUILD "\nlibraries  " HEXRELIEF_LIBRARIES;
}

constexpr int kBugExitCode = 1, kMemoryExitCode = 6;

const std::string kOutOfMemory =
    "out of memory; close other programs, or use smaller pictures or a larger mesh.spacing_px";

int complain(const std::string& message, int code) {
    files::wait_if_interrupted();  // an interrupt makes writes fail, which is no error to report
    print_error(message);
    return code;
}

}  // namespace

int run_command_line(int argc, char** argv) {
    files::guard_standard_streams();
    try {
        ArgumentParser parser("hexrelief",
                              "Stereo pairs and disparity maps to compact, textured, metric 3D meshes.",
                              version_text);
        Command program = parser.root();
        program.set_footer(R"(Examples:
  hexrelief run --left left.png --right right.png --calib calib.txt -o relief.glb
  hexrelief run --disparity disp.png --disparity-scale 4 --color left.png -o relief.obj
  hexrelief info relief.glb
  hexrelief demo
  hexrelief run --help)");
        add_run_command(program);
        add_batch_command(program);
        add_config_command(program);
        add_info_command(program);
        add_evaluate_command(program);
        add_gallery_command(program);
        add_devices_command(program);
        add_tiles_command(program);
        add_demo_command(program);
        add_manual_command(program);
        add_completion_command(program);
        const std::optional<Action> action = parser.parse(argc, argv);
        const int code = action ? (*action)() : 0;
        if (std::fflush(stdout) != 0 || std::ferror(stdout))
            throw Error(ErrorKind::output, "cannot write to standard output");
        return code;
    } catch (const Error& e) {
        return complain(e.what(), static_cast<int>(e.kind()));
    } catch (const std::filesystem::filesystem_error& e) {  // a file that vanished or is inaccessible
        return complain("cannot use '" + e.path1().string() + "': " + e.code().message(),
                        static_cast<int>(ErrorKind::input));
    } catch (const std::bad_alloc&) {
        return complain(kOutOfMemory, kMemoryExitCode);
    } catch (const std::system_error& e) {  // thrown if a thread cannot be made for lack of memory
        if (e.code() == std::errc::resource_unavailable_try_again)
            return complain(kOutOfMemory, kMemoryExitCode);
        return complain(std::string("internal error: ") + e.what(), kBugExitCode);
    } catch (const std::exception& e) {
        return complain(std::string("internal error: ") + e.what(), kBugExitCode);
    } catch (...) {
        return complain("internal error: unknown exception", kBugExitCode);
    }
}

}  // namespace hexrelief::cli
