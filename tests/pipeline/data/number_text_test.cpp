#include "pipeline/data/number_text.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "pipeline/readers/parse_text.h"

namespace hexrelief {
namespace {

TEST(NumberText, ListsAreJoined) {
    using Pair = std::pair<const char*, int>;
    const std::vector<Pair> pairs = {{"a", 1}, {"b", 2}};
    EXPECT_EQ(joined(std::vector<std::string>{"a", "b", "c"}, ", "), "a, b, c");
    EXPECT_EQ(joined(pairs, "|", &Pair::first), "a|b");
    EXPECT_EQ(joined(pairs, " x ", [](const Pair& pair) { return std::to_string(pair.second); }), "1 x 2");
    EXPECT_EQ(joined(std::vector<std::string>{}, ", "), "");
}

TEST(NumberText, SizesAreWidthAndHeight) {
    EXPECT_EQ(size_text(640, 480), "640x480");
    EXPECT_EQ(size_text(5000000000ull, 1ull, " x "), "5000000000 x 1");
}

TEST(ParseText, LettersBecomeSmall) {
    EXPECT_EQ(readers::codec::lower_case("AzZ_9\xc3\x84."), "azz_9\xc3\x84.");
}

}  // namespace
}  // namespace hexrelief
