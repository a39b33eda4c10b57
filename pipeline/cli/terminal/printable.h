// Text that holds names and values from outside, as a terminal may show it.
#pragma once

#include <string>

namespace hexrelief::cli {

// Control characters, marks that change the direction of writing and bytes that are no UTF-8 become "\x1b"
// and the like, so that a file's name cannot move the cursor, recolour or imitate other output; a line feed
// is kept where `lines` says that the text has several. A line of more than 2000 characters keeps its
// beginning and its end.
std::string printable(const std::string& text, bool lines = false);

// "hexrelief: warning: ..." on standard error.
void print_warning(const std::string& warning);

}  // namespace hexrelief::cli
