// 3D Tiles: boxes, errors and names of a quadtree with tiles that are missing.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "exporters/tileset/tileset.h"

namespace hexrelief {
namespace {

using Json = nlohmann::json;

// 3 x 2 tiles on level 2, but for (1, 0) and those of (1, 1) of level 1.
std::vector<TilesetTile> tiles() {
    const auto tile = [](int level, int x, int y, double error, bool has_content = true) {
        const double side = 8.0 / (1 << level), left = x * side, top = -y * side;
        return TilesetTile{level, x,          y, {left, top - side, -30.0 - level}, {left + side, top, -20},
                           error, has_content};
    };
    return {tile(2, 0, 0, 0), tile(1, 0, 0, 0.5), tile(2, 2, 0, 0), tile(1, 1, 0, 0.25),
            tile(0, 0, 0, 0.1, false)};
}

TEST(Tileset, NestsTilesInTheirParents) {
    const Json json = Json::parse(explicit_tileset(tiles(), "a/{level}/{x}/{y}.glb", "test"));
    EXPECT_EQ(json["asset"]["version"], "1.1");
    const Json& root = json["root"];
    EXPECT_FALSE(root.contains("content"));
    EXPECT_EQ(root["geometricError"], 0.5);  // at least that of its children
    ASSERT_EQ(root["children"].size(), 2u);
    const Json& child = root["children"][1];
    EXPECT_EQ(child["content"]["uri"], "a/1/1/0.glb");
    ASSERT_EQ(child["children"].size(), 1u);
    EXPECT_EQ(child["children"][0]["content"]["uri"], "a/2/2/0.glb");
    // centre (10, -2 up, -26) and halves (2, 2, 6) in glTF's axes: here z is up; holds the child's box as
    // well
    EXPECT_EQ(child["boundingVolume"]["box"], Json::parse("[6, 26, -2, 2, 0, 0, 0, 0, -2, 0, 6, 0]"));
    EXPECT_EQ(root["boundingVolume"]["box"][10], 6);
}

TEST(Tileset, SubtreesSayWhatIsThere) {
    const ImplicitTileset tileset = implicit_tileset(tiles(), "{level}/{x}/{y}.glb", "test");
    const Json json = Json::parse(tileset.json);
    EXPECT_EQ(json["root"]["implicitTiling"]["availableLevels"], 3);
    ASSERT_EQ(tileset.subtrees.size(), 1u);
    EXPECT_EQ(tileset.subtrees[0].name, "subtrees/0/0/0.subtree");
    const std::vector<std::uint8_t>& bytes = tileset.subtrees[0].bytes;
    ASSERT_GT(bytes.size(), 24u);
    EXPECT_EQ(std::memcmp(bytes.data(), "subt", 4), 0);
    std::uint64_t text = 0, binary = 0;
    std::memcpy(&text, &bytes[8], 8);
    std::memcpy(&binary, &bytes[16], 8);
    ASSERT_EQ(bytes.size(), 24 + text + binary);
    const Json subtree =
        Json::parse(bytes.begin() + 24, bytes.begin() + 24 + static_cast<std::ptrdiff_t>(text));
    const auto view = [&](const Json& index) {
        return bytes.begin() + 24 + static_cast<std::ptrdiff_t>(text) +
               subtree["bufferViews"][index.get<std::size_t>()]["byteOffset"].get<std::ptrdiff_t>();
    };
    // root; (0,0), (1,0) of level 1; of level 2 in Morton's order the first and, as (2,0), the fifth
    EXPECT_EQ(subtree["tileAvailability"]["availableCount"], 5);
    const auto bits = view(subtree["tileAvailability"]["bitstream"]);
    EXPECT_EQ(bits[0], 1 + 2 + 4 + 32);
    EXPECT_EQ(bits[1], 2);
    const auto contents = view(subtree["contentAvailability"][0]["bitstream"]);
    EXPECT_EQ(contents[0], 2 + 4 + 32);
    EXPECT_EQ(subtree["childSubtreeAvailability"]["constant"], 0);
    const Json& table = subtree["propertyTables"][0];
    EXPECT_EQ(table["count"], 5);
    double errors[5];
    std::memcpy(errors, &*view(table["properties"]["error"]["values"]), sizeof errors);
    EXPECT_EQ(errors[0], 0.5);
    EXPECT_EQ(errors[2], 0.25);
}

TEST(Tileset, HasSubtreesBelowSubtrees) {
    std::vector<TilesetTile> deep;
    for (int level = 0; level <= 6; ++level)
        deep.push_back({level, (1 << level) - 1, 0, {0, 0, -2}, {1, 1, -1}, 0, true});
    const ImplicitTileset tileset = implicit_tileset(deep, "{level}/{x}/{y}.glb", "test");
    ASSERT_EQ(tileset.subtrees.size(), 2u);
    EXPECT_EQ(tileset.subtrees[1].name, "subtrees/5/31/0.subtree");
}

}  // namespace
}  // namespace hexrelief
