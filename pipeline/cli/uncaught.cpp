#include "pipeline/cli/uncaught.h"

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>

#include "exporters/core/file_transaction.h"
#include "pipeline/batch/worker.h"

namespace hexrelief::cli {
namespace {

// Allocates nothing.
[[noreturn]] void end_by_exception() {
    static std::atomic_flag is_ending = ATOMIC_FLAG_INIT;
    while (is_ending.test_and_set()) ::pause();  // another thread does it
    try {
        if (std::current_exception()) std::rethrow_exception(std::current_exception());
    } catch (const std::bad_alloc&) {
        exporters::remove_pending_files();
        for (const char* part : {"hexrelief: ", batch::kOutOfMemory, "\n"})
            if (::write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
        ::_exit(batch::kMemoryExitCode);
    } catch (...) {
        std::fputs("hexrelief: internal error: an exception where none may be\n", stderr);
    }
    std::abort();
}

}  // namespace

void tell_of_uncaught_exceptions() {
    std::set_terminate(end_by_exception);
}

}  // namespace hexrelief::cli
