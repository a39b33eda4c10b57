#include "exporters/tileset/tileset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace hexrelief::tileset {
namespace {

using nlohmann::json;
using Box = std::array<double, 12>;
using Corners = std::pair<std::array<double, 3>, std::array<double, 3>>;  // lowest and highest

constexpr const char* kContent = "t/{level}/{x}/{y}.glb";
constexpr int kLevels = 7, kColumns = 37, kRows = 22;

std::string name_of(int level, int x, int y) {
    return "t/" + std::to_string(level) + "/" + std::to_string(x) + "/" + std::to_string(y) + ".glb";
}

// Returns tiles of unequal sizes; some tiles of the finest level are missing, and the root has no content.
std::vector<TilesetTile> made_up_tiles() {
    std::vector<TilesetTile> tiles;
    for (int level = 0; level < kLevels; ++level) {
        const int by = kLevels - 1 - level;
        for (int y = 0; y <= (kRows - 1) >> by; ++y)
            for (int x = 0; x <= (kColumns - 1) >> by; ++x) {
                if (by == 0 && (x + y) % 5 == 0) continue;
                TilesetTile tile{level, x, y, {}, {}, by * 0.5, level > 0};
                const auto at = [&](int i) { return 10.0 * (i << by) + 0.01 * (i << by) * (i << by); };
                tile.low_m = {at(x), -at(y + 1), -7.5 - x};
                tile.high_m = {at(x + 1), -at(y), -3.25 + y};
                tiles.push_back(tile);
            }
    }
    return tiles;
}

// Returns the corners of an axis-aligned box, in a tileset's axes.
Corners corners(const Box& box) {
    Corners out;
    for (std::size_t k = 0; k < 3; ++k) {
        const double half = std::abs(box[3 + k]) + std::abs(box[6 + k]) + std::abs(box[9 + k]);
        out.first[k] = box[k] - half;
        out.second[k] = box[k] + half;
    }
    return out;
}

bool holds(const Corners& outer, const Corners& inner) {
    bool is_inside = true;
    for (std::size_t k = 0; k < 3; ++k)
        is_inside =
            is_inside && inner.first[k] >= outer.first[k] - 1e-9 && inner.second[k] <= outer.second[k] + 1e-9;
    return is_inside;
}

struct Told {
    Box box{};
    double error_m = 0;
};

void read_node(const json& node, std::map<std::string, Told>& out) {
    const Told told{node["boundingVolume"]["box"].get<Box>(), node["geometricError"]};
    EXPECT_EQ(node["refine"], "REPLACE");
    const std::string uri = node.contains("content") ? node["content"]["uri"].get<std::string>() : "";
    EXPECT_TRUE(out.emplace(uri, told).second) << uri;
    for (const json& child : node.value("children", json::array())) {
        EXPECT_TRUE(holds(corners(told.box), corners(child["boundingVolume"]["box"].get<Box>()))) << uri;
        EXPECT_LE(child["geometricError"].get<double>(), told.error_m);
        read_node(child, out);
    }
}

TEST(Tileset, ExplicitFormHasEveryTile) {
    const std::vector<TilesetTile> tiles = made_up_tiles();
    const json document = json::parse(explicit_tileset(tiles, kContent, "test"));
    EXPECT_EQ(document["asset"]["version"], "1.1");
    EXPECT_GE(document["geometricError"].get<double>(), document["root"]["geometricError"].get<double>());
    std::map<std::string, Told> told;
    read_node(document["root"], told);
    ASSERT_EQ(told.size(), tiles.size());
    for (const TilesetTile& tile : tiles) {
        const std::string name = tile.has_content ? name_of(tile.level, tile.x, tile.y) : "";
        ASSERT_TRUE(told.count(name)) << name;
        // Up is y in glTF and z in a tileset.
        const auto& [low, high] = std::pair{tile.low_m, tile.high_m};
        EXPECT_TRUE(holds(corners(told[name].box), {{low[0], -high[2], low[1]}, {high[0], -low[2], high[1]}}))
            << name;
        EXPECT_EQ(told[name].error_m, tile.error_m);
    }
}

// A subtree file, parsed by the definition of 3D Tiles 1.1.
class Subtree {
  public:
    explicit Subtree(const std::vector<std::uint8_t>& bytes) {
        const auto number = [&](std::size_t at) {
            std::uint64_t value = 0;
            std::memcpy(&value, bytes.data() + at, sizeof value);
            return value;
        };
        EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "subt");
        EXPECT_EQ(number(0) >> 32, 1u);
        const std::uint64_t text = number(8), data = number(16);
        EXPECT_EQ(text % 8, 0u);
        EXPECT_EQ(data % 8, 0u);
        EXPECT_EQ(bytes.size(), 24 + text + data);
        json_ = json::parse(bytes.begin() + 24, bytes.begin() + 24 + static_cast<std::ptrdiff_t>(text));
        data_.assign(bytes.begin() + 24 + static_cast<std::ptrdiff_t>(text), bytes.end());
        EXPECT_EQ(json_["tileMetadata"], 0);
    }
    bool is_set(const json& availability, std::size_t bit) const {
        if (availability.contains("constant")) return availability["constant"] == 1;
        return (data_.at(view(availability["bitstream"]) + bit / 8) >> bit % 8 & 1) != 0;
    }
    bool has_tile(std::size_t bit) const { return is_set(json_["tileAvailability"], bit); }
    bool has_content(std::size_t bit) const { return is_set(json_["contentAvailability"][0], bit); }
    bool has_child(std::size_t morton) const { return is_set(json_["childSubtreeAvailability"], morton); }
    Told told(std::size_t bit) const {
        std::size_t row = 0;
        for (std::size_t k = 0; k < bit; ++k) row += has_tile(k);
        const json& values = json_["propertyTables"][0]["properties"];
        Told out;
        std::memcpy(out.box.data(), data_.data() + view(values["box"]["values"]) + row * sizeof out.box,
                    sizeof out.box);
        std::memcpy(&out.error_m, data_.data() + view(values["error"]["values"]) + row * 8, 8);
        return out;
    }
    json document() const { return json_; }

  private:
    std::size_t view(const json& index) const {
        return json_["bufferViews"][index.get<std::size_t>()]["byteOffset"];
    }
    json json_;
    std::vector<std::uint8_t> data_;
};

// Interleaves the bits of x and y, those of x in the even places.
std::size_t morton(int x, int y) {
    std::size_t out = 0;
    for (int bit = 0; bit < 16; ++bit)
        out |= static_cast<std::size_t>((x >> bit & 1) | (y >> bit & 1) << 1) << 2 * bit;
    return out;
}

TEST(Tileset, ImplicitFormSaysTheSame) {
    const std::vector<TilesetTile> tiles = made_up_tiles();
    std::map<std::string, Told> told;
    read_node(json::parse(explicit_tileset(tiles, kContent, "test"))["root"], told);
    const ImplicitTileset halved = implicit_tileset(tiles, kContent, "test");
    const json root = json::parse(halved.json)["root"];
    EXPECT_EQ(root["content"]["uri"], kContent);
    const json& tiling = root["implicitTiling"];
    EXPECT_EQ(tiling["subdivisionScheme"], "QUADTREE");
    EXPECT_EQ(tiling["availableLevels"], kLevels);
    EXPECT_EQ(tiling["subtrees"]["uri"], "subtrees/{level}/{x}/{y}.subtree");
    const int levels = tiling["subtreeLevels"];
    ASSERT_LT(levels, kLevels);  // the tree has subtrees below the first
    std::map<std::string, Subtree> subtrees;
    for (const auto& [name, bytes] : halved.subtrees) subtrees.emplace(name, Subtree(bytes));

    std::size_t found = 0;
    for (int level = 0; level < kLevels; ++level)
        for (int y = 0; y < 1 << level; ++y)
            for (int x = 0; x < 1 << level; ++x) {
                const int depth = level % levels;
                const std::string name = "subtrees/" + std::to_string(level - depth) + "/" +
                                         std::to_string(x >> depth) + "/" + std::to_string(y >> depth) +
                                         ".subtree";
                const bool is_there = told.count(level > 0 ? name_of(level, x, y) : "") > 0;
                const auto subtree = subtrees.find(name);
                if (subtree == subtrees.end()) {
                    EXPECT_FALSE(is_there) << name_of(level, x, y);
                    continue;
                }
                const int mask = (1 << depth) - 1;
                const std::size_t first = ((std::size_t{1} << 2 * depth) - 1) / 3,
                                  bit = first + morton(x & mask, y & mask);
                EXPECT_EQ(subtree->second.has_tile(bit), is_there) << name_of(level, x, y);
                EXPECT_EQ(subtree->second.has_content(bit), is_there && level > 0) << name_of(level, x, y);
                if (!is_there) continue;
                ++found;
                const Told expected = told[level > 0 ? name_of(level, x, y) : ""];
                EXPECT_EQ(subtree->second.told(bit).box, expected.box);
                EXPECT_EQ(subtree->second.told(bit).error_m, expected.error_m);
            }
    EXPECT_EQ(found, tiles.size());
    const Subtree& top = subtrees.at("subtrees/0/0/0.subtree");
    for (int y = 0; y < 1 << levels; ++y)
        for (int x = 0; x < 1 << levels; ++x)
            EXPECT_EQ(top.has_child(morton(x, y)),
                      subtrees.count("subtrees/" + std::to_string(levels) + "/" + std::to_string(x) + "/" +
                                     std::to_string(y) + ".subtree") > 0);
}

}  // namespace
}  // namespace hexrelief::tileset
