#include "pipeline/files/make_rule.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <random>

#include "pipeline/data/error.h"
#include "tests/pipeline/process.h"

namespace hexrelief::files {
namespace {

namespace fs = std::filesystem;
using std::chrono::hours;

// Names with line feeds stand in the message, which then has several lines.
bool is_refused(const std::string& name) {
    try {
        make_rule({"plain.glb"}, {name});
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::usage);
        EXPECT_CONTAINS(error.what(), name);
        return true;
    }
    return false;
}

bool has_make() {
    return std::system("make --version >/dev/null 2>&1") == 0;
}

// A folder in which `name` and `plain` are sources, and the targets are made from them by a rule of
// make_rule().
class MadeFolder {
  public:
    MadeFolder(const std::string& name, bool is_last, const std::string& first_line) : name_(name) {
        const std::string target = name + ".glb";
        const std::vector<fs::path> sources =
            is_last ? std::vector<fs::path>{"plain", name} : std::vector<fs::path>{name, "plain"};
        for (const fs::path& source : sources) put(source, hours(3));
        for (const fs::path& made : {fs::path(target), fs::path("made.glb")}) put(made, hours(2));
        test::write_text(folder_ / "rule.d", make_rule({target, "made.glb"}, sources));
        test::write_text(folder_ / "Makefile", first_line + "\n-include rule.d\n%.glb:\n\t@false\n");
    }

    // 0 = up to date, 1 = to be made, 2 = make does not understand. Without a goal, of the rule's first
    // target.
    int ask_make(const char* goal) const {
        const pid_t child = fork();
        if (child == 0) {
            execlp("make", "make", "-rRqs", "-C", folder_.path().c_str(), "--", goal, nullptr);
            _exit(127);
        }
        int status = 0;
        waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    void expect_followed(const char* goal) const {
        EXPECT_EQ(ask_make(goal), 0);
        const fs::path source = folder_.path() / name_;
        age(source, hours(1));
        EXPECT_EQ(ask_make(goal), 1) << "not made again after a change";
        fs::remove(source);
        EXPECT_EQ(ask_make(goal), 1) << "not made again without it";
    }

  private:
    static void age(const fs::path& path, hours by) {
        fs::last_write_time(path, fs::file_time_type::clock::now() - by);
    }
    void put(const fs::path& name, hours by) const {
        const fs::path path = folder_.path() / name;
        fs::create_directories(path.parent_path());
        std::ofstream(path) << "x";
        age(path, by);
    }

    test::TemporaryFolder folder_;
    std::string name_;
};

void expect_followed(const std::string& name) {
    SCOPED_TRACE(testing::PrintToString(name));
    ASSERT_FALSE(is_refused(name));
    // As a goal make would take `=` for an assignment and `~` for a home, and by itself it makes no goal with
    // `%`.
    const bool is_goal = name[0] != '~' && name.find('=') == std::string::npos;
    const std::string goal = !is_goal && name.find('%') != std::string::npos ? "made.glb" : name + ".glb";
    MadeFolder(name, false, "").expect_followed(is_goal || goal == "made.glb" ? goal.c_str() : nullptr);
    if (name.find('$') == std::string::npos)  // what follows `$` is a variable's name after .SECONDEXPANSION
        MadeFolder(name, true, ".SECONDEXPANSION:").expect_followed("made.glb");
}

TEST(MakeRule, GnuMakeFollowsNamesOfAllKinds) {
    if (!has_make()) GTEST_SKIP() << "NOTE: no make here: rules are not tested";
    for (const char* name : {"left image.png",
                             "a#b",
                             "a$b",
                             "a\\b",
                             "a\\ b",
                             "a\\#b",
                             "a\\:b",
                             "a\\\\b|c",
                             "100%",
                             "a\\%b",
                             "%a%b\\c",
                             "a:b",
                             "a|b.pfm",
                             "|",
                             "x=y.pfm",
                             "=",
                             "run=3/left.png",
                             "a:=b",
                             "~root",
                             "~",
                             "~root/left.png",
                             "a~b",
                             "scene[1].png",
                             "a*b",
                             "what?",
                             "[ab]",
                             "photo (1).png",
                             "a(b",
                             "R&D",
                             "R&",
                             "&",
                             "export",
                             "define",
                             "include",
                             "ifeq",
                             ".c",
                             ".c.o",
                             ".hidden/left.png",
                             "-f",
                             "@a",
                             "!a",
                             "a,b",
                             "'a'",
                             "\"a\"",
                             "`id`",
                             "a>b",
                             "\xc3\xa4",
                             "\xff"})
        expect_followed(name);
}

TEST(MakeRule, GnuMakeFollowsRandomNames) {
    if (!has_make()) GTEST_SKIP() << "NOTE: no make here: rules are not tested";
    std::mt19937 random(1);
    const std::string letters = "  ##$$\\\\%%::||==~~**??[](){}&!+@,'\"`<>^-.xY";
    int followed = 0;
    while (followed < 10 && !testing::Test::HasFailure()) {
        std::string name;
        for (unsigned i = 1 + random() % 5; i-- > 0;) name += letters[random() % letters.size()];
        if (random() % 3 == 0) name = "in" + name + "/left.png";
        if (name.find_first_not_of('.') == std::string::npos || is_refused(name)) continue;
        expect_followed(name);
        ++followed;
    }
}

TEST(MakeRule, WhatMakeCannotReadIsRefused) {
    for (const char* name :
         {"a\nb", "a\rb", "a\tb", "a\x7f", ";id>pwned;x=.pfm", "a\\;b", "$(shell id)", "${shell id}",
          "lib(member)", "a\\", "a ", "a\\*", "%*", "~\\", ".PHONY", ".SECONDEXPANSION"})
        EXPECT_TRUE(is_refused(name)) << testing::PrintToString(name);
    EXPECT_THROW(make_rule({}, {"left.png"}), Error);
    EXPECT_THROW(make_rule({"a;b.glb"}, {"left.png"}), Error);
}

}  // namespace
}  // namespace hexrelief::files
