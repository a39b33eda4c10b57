#include "pipeline/config/shell_words.h"

#include <iomanip>
#include <sstream>

#include "pipeline/data/error.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::config {

std::vector<std::string> words_of_line(const std::string& line) {
    std::istringstream text(line);
    std::vector<std::string> words;
    for (std::string word; text >> std::quoted(word, '"', '\0');) words.push_back(word);
    return words;
}

std::string shell_quoted(const std::string& word) {
    static const std::string kPlain =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./,:@%";
    if (word.find_first_of("\n\r") != std::string::npos)
        throw Error(ErrorKind::usage,
                    readers::codec::excerpt(word) + " holds a line end: no command line can");
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
    std::string quoted = "'";
    for (const char letter : word) quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
    return quoted + "'";
}

std::string shell_line(const std::vector<std::string>& words) {
    std::string line;
    for (const std::string& word : words) line += (line.empty() ? "" : " ") + shell_quoted(word);
    return line;
}

}  // namespace hexrelief::config
