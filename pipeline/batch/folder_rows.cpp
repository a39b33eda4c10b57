#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <utility>

#include "pipeline/batch/file_pattern.h"
#include "pipeline/batch/manifest_rows.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/parse_text.h"

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

std::string with_word(std::string text, const Sides& sides, std::string_view word) {
    return text.replace(sides.at, std::string_view(sides.words->left).size(), word);
}

// Returns the pattern with each word for left replaced, for folders that have it as well as their files.
std::string with_all_words(std::string text, const Sides& sides) {
    const std::string_view left = sides.words->left, right = sides.words->right;
    for (std::size_t at = 0; (at = text.find(left, at)) != std::string::npos; at += right.size())
        text.replace(at, left.size(), right);
    return text;
}

[[noreturn]] void refuse_pattern(const std::string& pattern) {
    const std::string words = joined(side_words(), ", ", &SideWords::left);
    throw Error(ErrorKind::usage, "pattern '" + pattern +
                                      "': must hold {name} once and a word for the left view (" + words +
                                      "), as '{name}_left.png' and '{name}/im0.png' do");
}

// Returns the file that the pattern without its ending and with "calib" in place of the word names.
fs::path calibration_of(const std::string& pattern, const Sides& sides, const std::string& name) {
    std::error_code none;
    const std::string stem = filled(
        with_word(pattern.substr(
                      0, std::max(pattern.rfind('.'), sides.at + std::string_view(sides.words->left).size())),
                  sides, "calib"),
        name);
    fs::path file = fs::path(stem + ".txt").lexically_normal();
    return fs::is_regular_file(file, none) ? file : fs::path();
}

using Files = std::map<std::string, fs::path>;  // by {name}

constexpr int kDeepest = 3;  // folders below the one given
constexpr std::streamsize kMarkedBytes = 1 << 20;
constexpr std::array<const char*, 6> kCalibrationEndings = {".txt", ".yaml", ".yml", ".json", ".xml", ".npz"};

// Returns the folder and those below it, a folder before its own. Links to folders are not followed.
std::vector<fs::path> folders_of(const fs::path& top, Listings& listings) {
    std::vector<fs::path> folders;
    const auto visit = [&](const auto& self, const fs::path& folder, int depth) -> void {
        folders.push_back(folder);
        if (depth == kDeepest) return;
        std::error_code none;
        for (const std::string& entry : listings.of(folder))
            if (const fs::path below = folder / entry;
                fs::is_directory(below, none) && !fs::is_symlink(below, none))
                self(self, below, depth + 1);
    };
    visit(visit, top, 0);
    return folders;
}

// Returns {name} without the separators at its ends: "scene" for "scene_" of scene_left.png.
std::string trimmed(const std::string& name) {
    constexpr const char* kSeparators = "_-. ";
    const std::size_t first = name.find_first_not_of(kSeparators);
    return first == std::string::npos ? name
                                      : name.substr(first, name.find_last_not_of(kSeparators) + 1 - first);
}

// Returns the first file of the rule's calibrations that exists; empty if there is none.
fs::path calibration_of(const PairRule& rule, const fs::path& folder, const std::string& name) {
    std::error_code none;
    for (std::string pattern : rule.calibrations) {
        constexpr std::string_view kFrame = "{frame}";
        if (const std::size_t at = pattern.find(kFrame); at != std::string::npos)
            pattern.replace(at, kFrame.size(), name.substr(0, name.rfind('_')));
        pattern = filled(pattern, name);
        const std::string stem = pattern.substr(0, pattern.size() - 2);  // without ".*"
        for (const char* const ending : kCalibrationEndings)
            if (const fs::path file = folder / (stem + ending); fs::is_regular_file(file, none)) return file;
    }
    return {};
}

// True if one of the words in {name} says that the file is a map: disp_left.png is no view.
bool names_map(const std::string& name) {
    static constexpr std::array<std::string_view, 4> kMaps = {"disp", "disparity", "depth", "mask"};
    std::string word;
    for (const char c : readers::codec::lower_case(name) + "_") {
        if (c >= 'a' && c <= 'z') {
            word += c;
            continue;
        }
        if (std::ranges::find(kMaps, word) != kMaps.end()) return true;
        word.clear();
    }
    return false;
}

bool holds(const fs::path& file, std::string_view marker) {
    std::ifstream stream(file, std::ios::binary);
    std::string head(static_cast<std::size_t>(kMarkedBytes), '\0');
    stream.read(head.data(), kMarkedBytes);
    head.resize(static_cast<std::size_t>(stream.gcount()));
    return head.find(marker) != std::string::npos;
}

class Finder {
  public:
    explicit Finder(const fs::path& top) : top_(top) {}

    std::vector<ManifestRow> rows() {
        const std::vector<fs::path> folders = folders_of(top_, listings_);
        for (const bool complete : {true, false})
            for (const fs::path& folder : folders)
                for (const PairRule& rule : pair_rules()) apply(rule, folder, complete);
        return std::move(rows_);
    }

  private:
    // Adds the rule's units in a folder: the complete ones, or those of which one view is missing.
    void apply(const PairRule& rule, const fs::path& folder, bool complete) {
        if (!complete && !(rule.needs_both && *rule.right && is_used(rule, folder))) return;
        Files lefts = files_like(folder, rule.left, NextToLetters::no_letter, listings_);
        Files rights =
            *rule.right ? files_like(folder, rule.right, NextToLetters::no_letter, listings_) : Files();
        for (Files* const files : {&lefts, &rights})
            std::erase_if(*files, [&](const auto& file) {
                return taken_.contains(file.second) || names_map(file.first) ||
                       (file.first.empty() && named_.contains(folder)) ||
                       (*rule.marker && !holds(file.second, rule.marker));
            });
        for (const auto& [name, left] : lefts) {
            const auto right = rights.find(name);
            if (!*rule.right)
                add(rule, folder, name, {left, {}});
            else if (complete && right != rights.end())
                add(rule, folder, name, {left, right->second});
            else if (!complete)
                add_lonely(rule, folder, name, left, "right", rule.right);
        }
        if (complete) return;
        for (const auto& [name, right] : rights) add_lonely(rule, folder, name, right, "left", rule.left);
    }

    // True if the rule has found a unit in the folder, or in any if folders name its units.
    bool is_used(const PairRule& rule, const fs::path& folder) const {
        return used_.contains(
            {&rule, std::string(rule.left).find(kName) == std::string::npos ? top_ : folder});
    }

    struct Views {
        fs::path left, right;  // right: empty if the left file holds both views
    };

    void add(const PairRule& rule, const fs::path& folder, const std::string& name, const Views& views) {
        ManifestRow row = new_row(rule, folder, name, views.left);
        const auto give = [&](const char* key, const fs::path& file) {
            if (!file.empty()) row.values.emplace_back(key, file.lexically_normal().string());
        };
        give(views.right.empty() ? "stereo" : "left", views.left);
        give("right", views.right);
        give("calib", calibration_of(rule, folder, name));
        if (*rule.layout) row.values.emplace_back("layout", rule.layout);
        rows_.push_back(std::move(row));
        taken_.insert(views.right);
        used_.insert({&rule, name.empty() ? top_ : folder});
    }

    void add_lonely(const PairRule& rule, const fs::path& folder, const std::string& name,
                    const fs::path& file, const char* missing, const char* pattern) {
        if (taken_.contains(file)) return;
        ManifestRow row = new_row(rule, folder, name, file);
        row.wrong = std::string("its ") + missing +
                    " image is missing: " + (folder / filled(pattern, name)).lexically_normal().string();
        rows_.push_back(std::move(row));
    }

    // Returns a row with its place, name and rule, and takes the file.
    ManifestRow new_row(const PairRule& rule, const fs::path& folder, const std::string& name,
                        const fs::path& file) {
        taken_.insert(file);
        if (name.empty()) named_.insert(folder);
        fs::path below = folder.lexically_relative(top_);
        if (below == ".")
            below = name.empty() ? fs::absolute(top_ / "").lexically_normal().parent_path().filename() : "";
        return {file.lexically_normal().string(),
                {{"name", (name.empty() ? below : below / trimmed(name)).string()}},
                {},
                std::string(rule.name) + " (" + rule.files() + ")"};
    }

    fs::path top_;
    Listings listings_;
    std::vector<ManifestRow> rows_;
    std::set<std::pair<const PairRule*, fs::path>> used_;
    std::set<fs::path> taken_, named_;  // files of a unit; folders whose name is that of a unit
};

}  // namespace

std::vector<ManifestRow> pattern_rows(const fs::path& path) {
    const std::string pattern = path.string();
    const Sides sides = sides_of(pattern);
    const std::size_t at = pattern.find(kName);
    if (!sides.words || at == std::string::npos || pattern.find(kName, at + 1) != std::string::npos)
        refuse_pattern(pattern);
    Listings listings;
    const auto lefts = files_like("", pattern, NextToLetters::any, listings);
    std::string right_pattern = with_word(pattern, sides, sides.words->right);
    auto rights = files_like("", right_pattern, NextToLetters::any, listings);
    if (rights.empty()) rights = files_like("", with_all_words(pattern, sides), NextToLetters::any, listings);
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

std::vector<ManifestRow> folder_rows(const fs::path& folder) {
    std::vector<ManifestRow> rows = Finder(folder).rows();
    if (!rows.empty()) return rows;
    const std::string known = joined(pair_rules(), "; ", &PairRule::files);
    throw Error(ErrorKind::input, "no pair is found in '" + folder.string() + "': pairs are " + known +
                                      "; by other names give a pattern with {name}, as '" +
                                      (folder / "{name}/left.*").string() + "', or a manifest");
}

}  // namespace hexrelief::batch
