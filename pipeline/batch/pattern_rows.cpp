#include <algorithm>

#include "pipeline/batch/file_pattern.h"
#include "pipeline/batch/manifest_rows.h"
#include "pipeline/batch/pair_rules.h"
#include "pipeline/data/error.h"

namespace hexrelief::batch {
namespace {

namespace fs = std::filesystem;

struct Sides {
    const SideWords* words = nullptr;
    std::size_t at = 0;  // of the word for left
};

// Returns the last word for left in a pattern.
Sides sides_of(const std::string& pattern) {
    Sides found;
    for (const SideWords& words : side_words())
        if (const std::size_t at = pattern.rfind(words.left);
            at != std::string::npos && (!found.words || at > found.at))
            found = {&words, at};
    return found;
}

std::string replaced(std::string text, const Sides& sides, std::string_view word) {
    return text.replace(sides.at, std::string_view(sides.words->left).size(), word);
}

// Returns the pattern with each word for left replaced, for folders that have it as well as their files.
std::string all_replaced(std::string text, const Sides& sides) {
    const std::string_view left = sides.words->left, right = sides.words->right;
    for (std::size_t at = 0; (at = text.find(left, at)) != std::string::npos; at += right.size())
        text.replace(at, left.size(), right);
    return text;
}

[[noreturn]] void refuse_pattern(const std::string& pattern) {
    std::string words;
    for (const SideWords& side : side_words()) words += (words.empty() ? "" : ", ") + std::string(side.left);
    throw Error(ErrorKind::usage, "pattern '" + pattern +
                                      "': must hold {name} once and a word for the left view (" + words +
                                      "), as '{name}_left.png' and '{name}/im0.png' do");
}

// Returns the file that the pattern without its ending and with "calib" in place of the word names.
fs::path calibration_of(const std::string& pattern, const Sides& sides, const std::string& name) {
    std::error_code none;
    const std::string stem = filled(
        replaced(pattern.substr(
                     0, std::max(pattern.rfind('.'), sides.at + std::string_view(sides.words->left).size())),
                 sides, "calib"),
        name);
    fs::path file = fs::path(stem + ".txt").lexically_normal();
    return fs::is_regular_file(file, none) ? file : fs::path();
}

}  // namespace

std::vector<ManifestRow> pattern_rows(const fs::path& path) {
    const std::string pattern = path.string();
    const Sides sides = sides_of(pattern);
    const std::size_t at = pattern.find(kName);
    if (!sides.words || at == std::string::npos || pattern.find(kName, at + 1) != std::string::npos)
        refuse_pattern(pattern);
    Listings listings;
    const auto lefts = files_like("", pattern, NextToLetters::any, listings);
    std::string right_pattern = replaced(pattern, sides, sides.words->right);
    auto rights = files_like("", right_pattern, NextToLetters::any, listings);
    if (rights.empty()) rights = files_like("", all_replaced(pattern, sides), NextToLetters::any, listings);
    std::vector<ManifestRow> rows;
    for (const auto& [name, left] : lefts) {
        ManifestRow row{left.lexically_normal().string(),
                        {{"name", name}, {"left", left.lexically_normal().string()}},
                        {}};
        if (const auto right = rights.find(name); right != rights.end())
            row.values.emplace_back("right", right->second.lexically_normal().string());
        else
            row.wrong = "its right image is missing: " +
                        fs::path(filled(right_pattern, name)).lexically_normal().string();
        if (const fs::path calibration = calibration_of(pattern, sides, name); !calibration.empty())
            row.values.emplace_back("calib", calibration.string());
        rows.push_back(std::move(row));
    }
    if (rows.empty()) throw Error(ErrorKind::input, "no pair is named as '" + pattern + "'");
    return rows;
}

}  // namespace hexrelief::batch
