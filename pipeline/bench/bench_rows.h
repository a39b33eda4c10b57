// Functions that all benchmarks share: the text of their rows, the times in them, the file that they go to.
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

// Formats a row as printf() does; cut off after 511 bytes.
std::string format(const char* pattern, auto... values) {
    char text[512];
    std::snprintf(text, sizeof text, pattern, values...);
    return text;
}

// Returns JSON as text. Names of scenes may not be UTF-8: invalid bytes become U+FFFD. indent: as for dump();
// -1 = one line.
std::string json_text(const nlohmann::ordered_json& json, int indent);

// Write a file, or nothing if the path is empty. Throw Error(output).
void write_json(const std::filesystem::path& path, const std::string& text);
void write_json(const std::filesystem::path& path, const nlohmann::ordered_json& json);

}  // namespace hexrelief::bench
