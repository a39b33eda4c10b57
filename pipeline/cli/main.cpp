#include "pipeline/cli/cli.h"

#include <cstdio>
#include <cstdlib>
#include <iostream>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

int main(int argc, char** argv) {
#if defined(__GLIBC__)
    // A stage gives megabytes back, and the next one asks for as many. Kept, they need not be mapped and
    // cleared page by page once more, for which threads wait for each other.
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
    // Without it a thread's heap grows page by page, by a system call each, while which no other thread may
    // map or clear pages.
    mallopt(M_TOP_PAD, 2 << 20);
#endif
    const int exit_code = hexrelief::cli::run_command_line(argc, argv);
#if defined(__SANITIZE_ADDRESS__)
    return exit_code;  // leaks are looked for
#else
    // All files are written and closed. What libraries would take down now, the CUDA runtime above all, the
    // system takes back sooner: 20 of 410 ms from a pair to a mesh.
    std::cout.flush();
    std::fflush(nullptr);
    std::_Exit(exit_code);
#endif
}
