#include "pipeline/cli/cli.h"

#include <cstdio>
#include <cstdlib>
#include <iostream>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

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
