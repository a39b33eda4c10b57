// What the house's order rests on, read off its own sources.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>

#include "tests/house/rooms.h"

namespace hexrelief::testing_house {
namespace {

namespace fs = std::filesystem;
const fs::path kRoot = HEXRELIEF_SOURCE_DIR;

// A longer file needs a reason, given here.
const std::map<std::string, std::string> kLongFiles = {};
constexpr std::size_t kLongestFile = 400;

// Lines with comments and string literals blanked out, good enough for house-keeping.
std::string code_of(const std::string& line) {
    static const std::regex text(R"("(\\.|[^"\\])*")"), comment("//.*");
    return std::regex_replace(std::regex_replace(line, text, "\"\""), comment, "");
}

// Characters, of which UTF-8 spends several bytes on some.
std::size_t columns(const std::string& line) {
    return static_cast<std::size_t>(
        std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

TEST(House, SourcesAreFound) {
    EXPECT_GT(all_sources().size(), 100u);
    for (const Room& room : rooms()) EXPECT_FALSE(source_files(kRoot, room.folder).empty()) << room.folder;
}

TEST(House, EveryFolderHasItsRoom) {
    for (const SourceFile& file : all_sources())
        EXPECT_NE(room_of(file.path), nullptr) << file.path << ": enter its folder in tests/house/rooms.cpp";
}

TEST(House, FoldersIncludeOnlyWhatTheyMay) {
    for (const SourceFile& file : all_sources())
        for (const std::string& offence : include_offences(file)) ADD_FAILURE() << offence;
}

// The test above must be able to fail.
TEST(House, ForbiddenIncludesAreNoticed) {
    const auto offences = [](const std::string& path, const std::string& line) {
        return include_offences({path, {line}}).size();
    };
    EXPECT_EQ(offences("pipeline/data/image.h", "#include \"mesher/mesher.h\""), 1u);
    EXPECT_EQ(offences("pipeline/stages/density.cpp", "#include \"pipeline/readers/image_reader.h\""), 1u);
    EXPECT_EQ(offences("mesher/quality/quality.cpp", "  #  include \"pipeline/config/config.h\""), 1u);
    EXPECT_EQ(offences("exporters/exporter.h", "#include \"mesher/quality/quality.h\""), 1u);
    EXPECT_EQ(offences("cuda/som/train_large.cu", "#include \"mesher/som/cellular_som.h\""), 1u);
    EXPECT_EQ(offences("cuda/som/train_large.cu", "#include \"mesher/som/best_matching_unit_step.h\""), 0u);
    EXPECT_EQ(offences("tests/pipeline/cli/run_test.cpp", "#include \"process.h\""), 0u) << "a sibling";
    EXPECT_EQ(offences("mesher/quality/quality.cpp", "#include \"common/lattice_step.h\""), 1u)
        << "paths start at the root";
    EXPECT_EQ(offences("mesher/quality/quality.cpp", "#include \"../mesher/quality/quality.h\""), 1u);
    EXPECT_EQ(offences("mesher/quality/quality.cpp", "#include <mesher/quality/quality.h>"), 0u);
    EXPECT_EQ(offences("mesher/quality/quality.cpp", "// #include \"pipeline/config/config.h\""), 0u);
    EXPECT_EQ(offences("pipeline/job/backend.cpp", "#include \"cuda/cuda_mesher.h\""), 0u);
    EXPECT_EQ(offences("pipeline/batch/table.cpp", "#include \"pipeline/cli/commands.h\""), 1u);
    EXPECT_EQ(offences("mesher/som/untangle.cpp", "#include \"mesher/balance/plan.h\""), 1u);
    EXPECT_EQ(offences("mesher/surface/pixels/speckles.cpp", "#include \"mesher/surface/fit/fit.h\""), 1u);
    EXPECT_EQ(offences("exporters/images/texture.cpp", "#include \"exporters/exporter.h\""), 1u);
}

TEST(House, NoFoldersIncludeEachOther) {
    std::vector<SourceFile> files = all_sources();
    std::erase_if(files, [](const SourceFile& file) { return file.path.starts_with("tests/"); });
    EXPECT_EQ(include_cycle(files), "");
}

// So must this one.
TEST(House, CyclesAreNoticed) {
    const auto file = [](const std::string& path, const std::string& target) {
        return SourceFile{path, {"#include \"" + target + "\""}};
    };
    EXPECT_EQ(include_cycle({file("a/x.h", "b/x.h"), file("a/y.h", "c/x.h"), file("b/x.h", "c/x.h")}), "");
    EXPECT_EQ(include_cycle({file("a/x.h", "a/y.h"), file("a/y.h", "a/x.h")}), "") << "one folder";
    EXPECT_EQ(include_cycle({file("a/x.h", "b/x.h"), file("b/y.h", "a/y.h")}), "a -> b -> a");
    EXPECT_EQ(include_cycle({file("a/x.h", "b/x.h"), file("b/x.h", "c/x.h"), file("c/x.h", "b/y.h")}),
              "b -> c -> b");
    EXPECT_EQ(include_cycle({file("a/x.h", "b/x.h"), file("b/x.h", "c/x.h"), file("c/x.h", "a/y.h")}),
              "a -> b -> c -> a");
}

TEST(House, OwnHeadersAreIncludedWithQuotes) {
    for (const SourceFile& file : all_sources())
        for (const std::string& line : file.lines) {
            const std::string target = angled_include(line);
            if (target.empty()) continue;
            EXPECT_EQ(room_of(target), nullptr) << file.path << " includes <" << target << ">";
        }
}

// One place picks a backend; nothing else outside cuda/ knows of the device.
TEST(House, OnlyTheBackendKnowsTheDevice) {
    static const std::regex runtime("cuda(_runtime|_runtime_api|\\.h)|device_launch");
    for (const SourceFile& file : all_sources())
        for (const std::string& line : file.lines) {
            const bool inside = file.path.starts_with("cuda/") || file.path.starts_with("tests/cuda/");
            if (!inside) {
                EXPECT_FALSE(std::regex_search(angled_include(line), runtime)) << file.path << ": " << line;
            }
            if (inside || file.path == "pipeline/job/backend.cpp" || file.path.starts_with("tests/house/"))
                continue;
            EXPECT_FALSE(quoted_include(line).starts_with("cuda/")) << file.path << ": " << line;
        }
}

// The library must be enough for what the program is for; other commands look into files, or measure.
TEST(House, RunIsAClientOfTheLibrary) {
    static const std::regex client("pipeline/cli/(command_run|run_options)\\.(h|cpp)");
    for (const SourceFile& file : all_sources())
        for (const std::string& line : file.lines) {
            const std::string target = quoted_include(line);
            if (!std::regex_match(file.path, client) || target.empty()) continue;
            EXPECT_TRUE(target.starts_with("pipeline/cli/") || target.starts_with("pipeline/data/"))
                << file.path << " includes " << target << ", which no other program could";
        }
}

TEST(House, FilesAreShort) {
    for (const SourceFile& file : all_sources()) {
        if (kLongFiles.contains(file.path)) continue;
        EXPECT_LE(file.lines.size(), kLongestFile)
            << file.path << ": split it, or give the reason in house_test.cpp";
    }
}

TEST(House, FoldersHoldFewFiles) {
    std::map<std::string, int> files;
    for (const SourceFile& file : all_sources()) ++files[file.path.substr(0, file.path.rfind('/'))];
    for (const auto& [folder, count] : files)
        EXPECT_LE(count, 30) << folder << ": make rooms of it, each with a task of its own";
}

TEST(House, LinesAreShort) {
    for (const SourceFile& file : all_sources())
        for (std::size_t i = 0; i < file.lines.size(); ++i)
            EXPECT_LE(columns(file.lines[i]), 110u) << file.path << ":" << i + 1;
    for (const SourceFile& file : other_files(kRoot))
        for (std::size_t i = 0; i < file.lines.size(); ++i) {
            const bool table = file.path.ends_with(".md") && file.lines[i].starts_with("|");
            if (!table) {
                EXPECT_LE(columns(file.lines[i]), 132u) << file.path << ":" << i + 1;
            }
        }
}

TEST(House, ReadmesAreShort) {
    for (const SourceFile& file : other_files(kRoot))
        if (fs::path(file.path).filename() == "README.md") {
            EXPECT_LE(file.lines.size(), file.path == "README.md" ? 150u : 60u) << file.path;
        }
}

// A notebook holds decisions; history is in git.
TEST(House, NotebooksAreShort) {
    int notebooks = 0;
    for (const SourceFile& file : other_files(kRoot)) {
        if (fs::path(file.path).filename() != "EXPERIMENTS.md") continue;
        ++notebooks;
        EXPECT_LE(file.lines.size(), 60u) << file.path << ": keep what the code still rests on";
    }
    EXPECT_GT(notebooks, 0);
}

TEST(House, HeadersGuardThemselves) {
    for (const SourceFile& file : all_sources()) {
        if (!file.path.ends_with(".h") && !file.path.ends_with(".cuh")) continue;
        EXPECT_NE(std::find(file.lines.begin(), file.lines.end(), "#pragma once"), file.lines.end())
            << file.path;
        EXPECT_TRUE(!file.lines.empty() && file.lines.front().starts_with("//"))
            << file.path << ": a header opens with a line that says what it is for";
    }
}

TEST(House, SourcesAreListedNotGlobbed) {
    const std::vector<SourceFile> files = cmake_files(kRoot);
    EXPECT_GT(files.size(), 8u);
    static const std::regex glob(R"(file\s*\(\s*GLOB)", std::regex::icase);
    for (const SourceFile& file : files)
        for (const std::string& line : file.lines)
            EXPECT_FALSE(std::regex_search(line, glob) ||
                         line.find("aux_source_directory") != std::string::npos)
                << file.path << ": " << line;
}

// True if a line of a step may round otherwise on a device, or depend on a thread.
bool rounds_apart(const std::string& line) {
    static const std::regex math(
        R"(\b(pow|exp|exp2|log|log2|sin|cos|tan|atan|atan2|hypot|fma|cbrt|rsqrt|__\w+_r[nzud])f?\s*\()");
    return std::regex_search(code_of(line), math) || code_of(line).find("thread") != std::string::npos;
}

// The steps are compiled for both backends, which must round alike: no functions of <cmath> but a square
// root.
TEST(House, StepsHoldOnlyWhatRoundsAlike) {
    std::map<std::string, int> steps;
    for (const SourceFile& file : all_sources()) {
        if (!file.path.ends_with("_step.h")) continue;
        ++steps[file.path.substr(0, file.path.find('/', file.path.find('/') + 1))];
        for (const std::string& line : file.lines)
            EXPECT_FALSE(rounds_apart(line)) << file.path << ": " << line;
    }
    for (const char* folder : {"mesher/som", "mesher/balance", "mesher/surface", "pipeline/matching"})
        EXPECT_GT(steps[folder], 0) << folder;
}

TEST(House, WhatRoundsApartIsNoticed) {
    EXPECT_TRUE(rounds_apart("    return floorf(fmaf(x, scale, half));"));
    EXPECT_TRUE(rounds_apart("const double far = std::hypot(dx, dy);"));
    EXPECT_TRUE(rounds_apart("int lane = threadIdx.x;"));
    EXPECT_FALSE(rounds_apart("return sqrtf(dx * dx + dy * dy);  // no hypot(dx, dy)"));
}

// The rooms whose code other programs link: all but the command line, the samples and the tests.
bool is_library(const std::string& path) {
    for (const char* program : {"pipeline/cli/", "samples/", "tests/"})
        if (path.starts_with(program)) return false;
    return true;
}

// One line for each place that prints or ends the process.
std::vector<std::string> speech_and_exits(const SourceFile& file) {
    static const std::regex speech(
        R"(\bstd::(cout|cerr|clog)\b|\b(f|v|vf)?printf\s*\(|\bf?puts\s*\(|\b(perror|stderr)\b)"),
        exits(R"(\b(_?exit|abort|quick_exit|std::terminate)\s*\()");
    // All but the last end processes that they have forked. The last ends a program that has called
    // install_interrupt_handling().
    static const std::set<std::string> may_exit = {
        "exporters/inspect/limited.cpp", "pipeline/batch/worker.cpp",
        "pipeline/job/matchers/child_program.cpp", "pipeline/files/interrupt.cpp"};
    std::vector<std::string> found;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
        const auto has = [&](const std::string& code) {
            return std::regex_search(code, speech) ||
                   (!may_exit.contains(file.path) && std::regex_search(code, exits));
        };
        if (has(file.lines[i]) && has(code_of(file.lines[i])))
            found.push_back(file.path + ":" + std::to_string(i + 1) + ": " + file.lines[i]);
    }
    return found;
}

TEST(House, LibrariesNeverPrintAndNeverExit) {
    for (const SourceFile& file : all_sources())
        if (is_library(file.path))
            for (const std::string& line : speech_and_exits(file)) ADD_FAILURE() << line;
}

TEST(House, PrintingAndExitingAreNoticed) {
    const auto found = [](const std::string& path, const std::string& line) {
        return speech_and_exits({path, {line}}).size();
    };
    EXPECT_EQ(found("pipeline/job/surfaces.cpp", "std::cout << 1;"), 1u);
    EXPECT_EQ(found("pipeline/job/surfaces.cpp", "exit(1);  // done"), 1u);
    EXPECT_EQ(found("pipeline/job/surfaces.cpp", "f(\"exit(1)\");  // exit(1)"), 0u);
    EXPECT_EQ(found("pipeline/job/surfaces.cpp", "std::snprintf(text, size, format);"), 0u);
    EXPECT_EQ(found("pipeline/batch/worker.cpp", "_exit(0);"), 0u);
    EXPECT_EQ(found("pipeline/batch/worker.cpp", "std::puts(text);"), 1u);
}

TEST(House, EveryRoomOpensWithAReadme) {
    for (const Room& room : rooms())
        EXPECT_TRUE(fs::exists(kRoot / room.folder / "README.md")) << room.folder;
}

TEST(House, MainIsShort) {
    for (const SourceFile& file : source_files(kRoot, "pipeline/cli"))
        if (file.path == "pipeline/cli/main.cpp") {
            EXPECT_LT(file.lines.size(), 100u);
            return;
        }
    ADD_FAILURE() << "pipeline/cli/main.cpp is missing";
}

}  // namespace
}  // namespace hexrelief::testing_house
