#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

#include "hexrelief_build_info.h"  // made by pipeline/cli/build_info.cmake
#include "pipeline/batch/worker.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"
#include "pipeline/cli/uncaught.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace hexrelief::cli {
namespace {

// Returns "hexrelief 0.2.0"; if verbose, also lines with commit, compiler, CUDA and libraries.
std::string version_text(bool verbose) {
    const std::string version = "hexrelief " HEXRELIEF_VERSION;
    if (!verbose) return version;
    return version + "\ncommit     " HEXRELIEF_COMMIT "\nbuild      " HEXRELIEF_BUILD
                     "\nCUDA       " HEXRELIEF_CUDA_BUILD "\nlibraries  " HEXRELIEF_LIBRARIES;
}

int complain(const std::string& message, int code) {
    files::wait_if_interrupted();  // an interrupt makes writes fail, which is no error to report
    print_error(message);
    return code;
}

// Prints to stdout and stderr. Never throws: an exception from a command becomes a message of one line and
// its exit code.
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
    } catch (...) {
        const batch::UnitResult failed = batch::result_of_exception();
        return complain(failed.message, failed.exit_code);
    }
}

}  // namespace
}  // namespace hexrelief::cli

int main(int argc, char** argv) {
#if defined(__GLIBC__)
    // Keeps freed memory in the process, because each stage frees megabytes that the next one needs
    // again. Memory from the system would have to be mapped and cleared page by page, while threads
    // wait for each other.
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
    // Lets a thread's heap grow in large steps. By default it grows page by page, each by a system call
    // during which no other thread can map or clear pages.
    mallopt(M_TOP_PAD, 2 << 20);
#endif
    hexrelief::cli::tell_of_uncaught_exceptions();
    const int exit_code = hexrelief::cli::run_command_line(argc, argv);
#if !defined(NDEBUG) && !defined(__SANITIZE_THREAD__)
    // Runs the sanitizer's search for leaks, and writes what coverage has counted.
    return exit_code;
#else
    // All files are written and closed. The process ends without its destructors, because the system frees
    // what libraries hold, the CUDA runtime above all, sooner than they do: this saves 20 of 410 ms from a
    // pair to a mesh.
    std::cout.flush();
    std::fflush(nullptr);
    std::_Exit(exit_code);
#endif
}
