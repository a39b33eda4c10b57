// What all benchmarks share: the text of their rows, the times in them, the file that they go to.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief {

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

// Writes nothing where no path is given. Throws Error(output).
void write_json(const std::filesystem::path& path, const std::string& text);

}  // namespace hexrelief
