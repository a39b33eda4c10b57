// Two types of one name in one namespace are one type to the linker, whichever headers a source reads.
#include "tests/house/names.h"

#include <gtest/gtest.h>

namespace hexrelief::testing_house {
namespace {

using Strings = std::vector<std::string>;

TEST(House, TypesAreDefinedOnce) {
    const std::vector<SourceFile> files = all_sources();
    std::size_t types = 0;
    for (const SourceFile& file : files) types += defined_types(file).size();
    EXPECT_GT(types, 500u);
    for (const std::string& offence : types_defined_twice(files)) ADD_FAILURE() << offence;
}

TEST(House, NamespacesAreTheRooms) {
    std::size_t namespaces = 0;
    for (const SourceFile& file : all_sources()) {
        namespaces += opened_namespaces(file).size();
        for (const std::string& offence : foreign_namespaces(file)) ADD_FAILURE() << offence;
    }
    EXPECT_GT(namespaces, 500u);
}

TEST(House, HeadersHaveNamesOfTheirOwn) {
    for (const std::string& offence : headers_named_alike(all_sources())) ADD_FAILURE() << offence;
}

// The tests above must be able to fail.
TEST(House, TypesOfOneNameAreNoticed) {
    const SourceFile one{"pipeline/stages/densify/a.h",
                         {"#define STRUCT struct Macro {}",
                          "namespace hexrelief::stages {",
                          "struct Ahead;  // struct Comment {};",
                          "struct VoteInput { struct Inner {}; };",
                          "enum class Kind : int { none };",
                          "template <typename T>",
                          "class Grid {};",
                          "template <>",
                          "class Grid<int> {};",
                          "struct alignas(16) Block {};",
                          "struct Block::Part {};",
                          "using Row = std::vector<int>;",
                          "inline void f() { struct Local {}; }",
                          "constexpr const char* kText = \"{\";",
                          "namespace {",
                          "struct Hidden {};",
                          "}",
                          "inline namespace v0 {",
                          "struct Public {};",
                          "}",
                          "namespace deep {",
                          "struct Deep {};",
                          "}",
                          "}"}};
    EXPECT_EQ(defined_types(one),
              (Strings{"hexrelief::stages::VoteInput", "hexrelief::stages::Kind", "hexrelief::stages::Grid",
                       "hexrelief::stages::Block", "hexrelief::stages::Row", "hexrelief::stages::Public",
                       "hexrelief::stages::deep::Deep"}));
    const auto defining = [](const std::string& path, const std::string& space) {
        return SourceFile{path, {"namespace " + space + " {", "struct VoteInput {};", "}"}};
    };
    EXPECT_EQ(types_defined_twice({one, defining("b.h", "hexrelief::matching")}).size(), 0u);
    EXPECT_EQ(types_defined_twice({one, defining("b.h", "hexrelief::stages")}).size(), 1u);
}

TEST(House, ForeignNamespacesAreNoticed) {
    const auto offences = [](const std::string& path, const std::string& space) {
        return foreign_namespaces({path, {"namespace " + space + " {", "}"}}).size();
    };
    EXPECT_TRUE(foreign_namespaces({"exporters/core/mesh_format.h",
                                    {"namespace hexrelief::inspect {", "struct Ahead;", "}"}})
                    .empty());
    EXPECT_EQ(offences("pipeline/data/image.h", "hexrelief"), 0u);
    EXPECT_EQ(offences("pipeline/stages/density.h", "hexrelief"), 1u);
    EXPECT_EQ(offences("pipeline/stages/density.h", "hexrelief::stages"), 0u);
    EXPECT_EQ(offences("pipeline/readers/tiff/tiff_codec.h", "hexrelief::readers::codec"), 0u);
    EXPECT_EQ(offences("pipeline/matching/refine/vote_step.h", "hexrelief::step"), 0u);
    EXPECT_EQ(offences("pipeline/matching/refine/votes.h", "hexrelief::step"), 1u);
    EXPECT_EQ(offences("pipeline/library/run.h", "hexrelief"), 0u);
    EXPECT_EQ(offences("mesher/mesher.h", "hexrelief::mesher"), 0u);
    EXPECT_EQ(offences("mesher/surface/fit/fit_disparities.h", "hexrelief::surface"), 0u);
    EXPECT_EQ(offences("cuda/surface/fit/fit_disparities.h", "hexrelief::cuda"), 0u);
    EXPECT_EQ(offences("exporters/formats/ply_exporter.cpp", "hexrelief::exporters"), 0u);
    EXPECT_EQ(offences("tests/pipeline/stages/density_test.cpp", "hexrelief::stages"), 0u);
    EXPECT_EQ(offences("tests/pipeline/stages/density_test.cpp", "hexrelief"), 1u);
}

TEST(House, HeadersOfOneNameAreNoticed) {
    const auto alike = [](const std::string& one, const std::string& other) {
        return headers_named_alike({{one, {}}, {other, {}}}).size();
    };
    EXPECT_EQ(alike("pipeline/stages/densify/votes.h", "pipeline/matching/refine/votes.h"), 1u);
    EXPECT_EQ(alike("cuda/matching/refine/votes.h", "pipeline/matching/refine/votes.h"), 0u) << "twins";
    EXPECT_EQ(alike("mesher/balance/balance.h", "cuda/som/balance.h"), 1u);
    EXPECT_EQ(alike("mesher/balance/balance.cpp", "pipeline/job/balance.cpp"), 0u) << "no headers";
}

}  // namespace
}  // namespace hexrelief::testing_house
