#include "pipeline/config/shell_words.h"

#include <algorithm>
#include <cstdio>
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
    // The escapes of bash, zsh and ksh: a terminal would obey control characters (C1's are 2 bytes of UTF-8).
    const auto is_control = [](unsigned char letter) { return letter < 0x20 || letter == 0x7f; };
    if (std::ranges::any_of(word, is_control) || word.find('\xc2') != std::string::npos) {
        std::string escaped = "$'";
        for (const char letter : word) {
            char code[8];
            std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned char>(letter));
            const bool is_ascii = letter >= 0x20 && letter < 0x7f;
            escaped += !is_ascii                          ? code
                       : letter == '\'' || letter == '\\' ? std::string("\\") + letter
                                                          : std::string(1, letter);
        }
        return escaped + "'";
    }
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
