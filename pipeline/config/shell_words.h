// Reads and writes the words of a command line.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::config {

// Returns the words between white space; "double quotes" hold spaces, and a doubled quote in
// them is one quote.
std::vector<std::string> words_of_line(const std::string& line);

// Returns the word as a POSIX shell reads it back, on one line, in single quotes if necessary. Throws
// Error(usage) for a word with a line end, which a line cannot hold.
std::string shell_quoted(const std::string& word);
std::string shell_line(const std::vector<std::string>& words);

}  // namespace hexrelief::config
