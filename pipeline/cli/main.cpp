#include "pipeline/cli/cli.h"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

int main(int argc, char** argv) {
#if defined(__GLIBC__)
    // A stage gives megabytes back, and the next one asks for as many. Kept, they need not be mapped and
    // cleared page by page once more, for which threads wait for each other.
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
    return hexrelief::run_command_line(argc, argv);
}
