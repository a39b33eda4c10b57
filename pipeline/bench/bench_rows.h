// What all benchmarks share: the text of their rows, the times in them, the file that they go to.
#pragma once

#include <cstdio>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace hexrelief::bench {

// Seconds of several runs, in any order. Without a run each figure is NaN.
struct Times {
    std::vector<double> runs;

    bool empty() const { return runs.empty(); }
    double median() const;
    double least() const;
    double most() const;
};

// As printf() writes them; a longer row than 512 bytes is cut off.
std::string format(const char* pattern, auto... values) {
    char text[512];
    std::snprintf(text, sizeof text, pattern, values...);
    return text;
}

// Names of scenes need not be UTF-8: what is not becomes U+FFFD. indent as of dump(); -1 = one line.
std::string json_text(const nlohmann::ordered_json& json, int indent);

// Write nothing where no path is given. Throw Error(output).
void write_json(const std::filesystem::path& path, const std::string& text);
void write_json(const std::filesystem::path& path, const nlohmann::ordered_json& json);

}  // namespace hexrelief::bench
