// What the program does with exceptions that nothing can catch.
#pragma once

namespace hexrelief::cli {

// From now on an exception that leaves a destructor or a handler ends the program in one line. If memory has
// ended, which some of the libraries' destructors need, it exits as for any lack of memory, and temporary
// files are removed; else it aborts.
void tell_of_uncaught_exceptions();

}  // namespace hexrelief::cli
