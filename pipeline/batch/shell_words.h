// Words of a command line, read and written.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::batch {

// Words between white space; "double quotes" hold spaces, and a doubled quote in them is one.
std::vector<std::string> words_of_line(const std::string& line);

// As a POSIX shell reads it back, on one line: in single quotes where it has to be. Throws Error(usage) for a
// word with a line end, which no line can hold.
std::string shell_quoted(const std::string& word);
std::string shell_line(const std::vector<std::string>& words);

}  // namespace hexrelief::batch
