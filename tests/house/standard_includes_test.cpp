// Every source includes the standard headers whose names it uses, itself or by the project's headers. The
// compiler does not say so where headers are precompiled.
#include <gtest/gtest.h>

#include <cctype>
#include <map>
#include <set>
#include <sstream>

#include "tests/house/rooms.h"

namespace hexrelief::testing_house {
namespace {

// Names in std by the header that they come from. Names that many headers bring (size_t, move, swap) are left
// out.
const std::map<std::string, std::string>& names_by_header() {
    static const std::map<std::string, std::string> names = {
        {"algorithm",
         "all_of any_of clamp copy copy_if copy_n count count_if equal fill fill_n find find_if lower_bound "
         "max max_element min min_element minmax minmax_element none_of nth_element partition_point replace "
         "reverse sort stable_sort transform upper_bound"},
        {"array", "array"},
        {"atomic",
         "atomic atomic_ref memory_order_acq_rel memory_order_acquire memory_order_relaxed "
         "memory_order_release"},
        {"bit", "bit_cast bit_width countr_zero endian"},
        {"cctype", "isalnum isdigit isspace tolower"},
        {"charconv", "from_chars to_chars"},
        {"chrono", "chrono"},
        {"cmath",
         "acos atan2 cbrt ceil cos exp fabs floor hypot isfinite isinf isnan ldexp log log2 lround nan "
         "nearbyint pow round sin sqrt tan"},
        {"cstdint", "int16_t int32_t int64_t int8_t uint16_t uint32_t uint64_t uint8_t uintmax_t uintptr_t"},
        {"cstdio", "fclose ferror fflush fopen fprintf fputc fputs fread fwrite printf snprintf vsnprintf"},
        {"cstring", "memcpy memset strerror strncpy"},
        {"deque", "deque"},
        {"exception", "current_exception exception_ptr rethrow_exception"},
        {"filesystem", "filesystem"},
        {"fstream", "ifstream ofstream"},
        {"functional", "function less"},
        {"future", "async future launch"},
        {"iomanip", "quoted"},
        {"iterator", "back_inserter"},
        {"limits", "numeric_limits"},
        {"map", "map"},
        {"memory", "make_shared make_unique shared_ptr unique_ptr"},
        {"mutex", "lock_guard mutex"},
        {"numbers", "numbers"},
        {"numeric", "accumulate exclusive_scan iota partial_sum"},
        {"optional", "nullopt optional"},
        {"random", "mt19937 mt19937_64"},
        {"set", "set"},
        {"span", "span"},
        {"sstream", "istringstream ostringstream stringstream"},
        {"stdexcept", "length_error logic_error runtime_error"},
        {"string", "getline stoi string to_string"},
        {"string_view", "string_view"},
        {"thread", "thread"},
        {"tuple", "tie tuple"},
        {"type_traits",
         "conditional_t decay_t is_floating_point_v is_same_v is_trivially_copyable_v is_void_v "
         "remove_reference_t"},
        {"variant", "get_if holds_alternative monostate variant visit"},
        {"vector", "vector"},
    };
    return names;
}

struct Uses {
    std::set<std::string> standard;             // <headers>
    std::vector<std::string> own;               // "headers"
    std::map<std::string, std::string> needed;  // header -> a name that needs it
};

// The names after "std::" in a line, without comments and string literals.
std::vector<std::string> standard_names(const std::string& line) {
    std::vector<std::string> names;
    const auto in_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '\\') {
            ++i;
        } else if (line[i] == '"' && !(i > 0 && line[i - 1] == '\'')) {
            quoted = !quoted;
        } else if (!quoted && line.compare(i, 2, "//") == 0) {
            break;
        } else if (!quoted && line.compare(i, 5, "std::") == 0 && (i == 0 || !in_word(line[i - 1]))) {
            std::size_t end = i + 5;
            while (end < line.size() && in_word(line[end])) ++end;
            names.push_back(line.substr(i + 5, end - i - 5));
        }
    }
    return names;
}

Uses uses_of(const SourceFile& file) {
    static const std::map<std::string, std::string> header_of = [] {
        std::map<std::string, std::string> headers;
        for (const auto& [header, names] : names_by_header()) {
            std::istringstream words(names);
            for (std::string name; words >> name;) headers[name] = header;
        }
        return headers;
    }();
    Uses uses;
    for (const std::string& line : file.lines) {
        if (const std::string header = angled_include(line); !header.empty()) uses.standard.insert(header);
        if (const std::string header = quoted_include(line); !header.empty()) uses.own.push_back(header);
        for (const std::string& name : standard_names(line))
            if (const auto found = header_of.find(name); found != header_of.end())
                uses.needed[found->second] = name;
    }
    return uses;
}

using Sources = std::map<std::string, Uses>;  // by their paths

void add_reached(const Sources& sources, const std::string& path, std::set<std::string>& visited,
                 std::set<std::string>& headers) {
    const auto found = sources.find(path);
    if (found == sources.end() || !visited.insert(path).second) return;
    headers.insert(found->second.standard.begin(), found->second.standard.end());
    for (const std::string& header : found->second.own) add_reached(sources, header, visited, headers);
}

// One line for each header that a source uses and does not reach.
std::vector<std::string> missing_includes(const std::vector<SourceFile>& files) {
    Sources sources;
    for (const SourceFile& file : files) sources[file.path] = uses_of(file);
    std::vector<std::string> missing;
    for (const auto& [path, uses] : sources) {
        std::set<std::string> visited, headers;
        add_reached(sources, path, visited, headers);
        for (const auto& [header, name] : uses.needed)
            if (!headers.contains(header))
                missing.push_back(path + " uses std::" + name + " without <" + header + ">");
    }
    return missing;
}

TEST(StandardIncludes, AreNoticedWhereTheyAreMissing) {
    const SourceFile header{"a/a.h", {"#include <vector>", "#include \"a/b.h\""}},
        inner{"a/b.h", {"#include <map>"}};
    const SourceFile source{"a/a.cpp",
                            {"#include \"a/a.h\"", "std::vector<int> a; std::map<int, int> b;",
                             "f(\"std::set\", '\"');  // std::optional", "std::size_t n = std::min(1, 2);"}};
    EXPECT_EQ(missing_includes({header, inner, source}),
              std::vector<std::string>{"a/a.cpp uses std::min without <algorithm>"});
    EXPECT_EQ(missing_includes({header, source}).size(), 2u);
}

TEST(StandardIncludes, AreAllThere) {
    const std::filesystem::path root = HEXRELIEF_SOURCE_DIR;
    std::vector<SourceFile> files;
    for (const char* folder : {"pipeline", "mesher", "exporters", "samples", "cuda"})
        for (const SourceFile& file : source_files(root, folder)) files.push_back(file);
    EXPECT_GT(files.size(), 200u);
    for (const std::string& missing : missing_includes(files)) ADD_FAILURE() << missing;
}

}  // namespace
}  // namespace hexrelief::testing_house
