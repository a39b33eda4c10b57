#include "exporters/tileset/tileset.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

namespace hexrelief::tileset {
namespace {

using Json = nlohmann::ordered_json;
using Key = std::tuple<int, int, int>;  // level, x, y
using Tree = std::map<Key, TilesetTile>;

constexpr int kSubtreeLevels = 5;

// Returns the tiles as a tree in which boxes and errors include those below.
Tree tree_of(const std::vector<TilesetTile>& tiles) {
    Tree tree;
    for (const TilesetTile& tile : tiles) tree[{tile.level, tile.x, tile.y}] = tile;
    for (auto it = tree.rbegin(); it != tree.rend(); ++it) {
        const TilesetTile& tile = it->second;
        if (tile.level == 0) continue;
        TilesetTile& parent = tree.at({tile.level - 1, tile.x / 2, tile.y / 2});
        const bool is_first = parent.low_m == parent.high_m;
        for (std::size_t k = 0; k < 3; ++k) {
            parent.low_m[k] = is_first ? tile.low_m[k] : std::min(parent.low_m[k], tile.low_m[k]);
            parent.high_m[k] = is_first ? tile.high_m[k] : std::max(parent.high_m[k], tile.high_m[k]);
        }
        parent.error_m = std::max(parent.error_m, tile.error_m);
    }
    return tree;
}

// Returns the box for 3D Tiles. Up is y in glTF and z in a tileset: (x, y, z) becomes (x, -z, y). The half
// axes are those of the picture's columns, of its rows from the top, and of depth, because implicit tiling
// halves the first two.
std::array<double, 12> box_of(const TilesetTile& tile) {
    std::array<double, 3> centre{}, half{};
    for (std::size_t k = 0; k < 3; ++k) {
        centre[k] = tile.low_m[k] / 2 + tile.high_m[k] / 2;
        half[k] = tile.high_m[k] / 2 - tile.low_m[k] / 2;
    }
    return {centre[0], -centre[2], centre[1], half[0], 0, 0, 0, 0, -half[1], 0, half[2], 0};
}

double diagonal(const TilesetTile& tile) {
    double squares = 0;
    for (std::size_t k = 0; k < 3; ++k)
        squares += (tile.high_m[k] - tile.low_m[k]) * (tile.high_m[k] - tile.low_m[k]);
    return std::sqrt(squares);
}

void replace(std::string& text, const std::string& what, int by) {
    text.replace(text.find(what), what.size(), std::to_string(by));
}

std::string content_name(std::string name, const TilesetTile& tile) {
    replace(name, "{level}", tile.level);
    replace(name, "{x}", tile.x);
    replace(name, "{y}", tile.y);
    return name;
}

Json document_of(const Tree& tree, const std::string& generator) {
    return {{"asset", {{"version", "1.1"}, {"generator", generator}}},
            {"geometricError", diagonal(tree.at({0, 0, 0}))}};
}

Json node_of(const Tree& tree, const TilesetTile& tile, const std::string& content) {
    Json json;
    json["boundingVolume"]["box"] = box_of(tile);
    json["geometricError"] = tile.error_m;
    json["refine"] = "REPLACE";
    if (tile.has_content) json["content"]["uri"] = content_name(content, tile);
    Json children = Json::array();
    for (int y = 2 * tile.y; y <= 2 * tile.y + 1; ++y)
        for (int x = 2 * tile.x; x <= 2 * tile.x + 1; ++x)
            if (const auto child = tree.find({tile.level + 1, x, y}); child != tree.end())
                children.push_back(node_of(tree, child->second, content));
    if (!children.empty()) json["children"] = std::move(children);
    return json;
}

// An array of bits, the first one in the lowest place of the first byte.
struct Bits {
    std::vector<std::uint8_t> bytes;
    std::size_t size = 0, set = 0;

    void add(bool value) {
        if (size % 8 == 0) bytes.push_back(0);
        if (value) bytes.back() |= static_cast<std::uint8_t>(1u << size % 8);
        set += value;
        ++size;
    }
};

// Returns x and y of the m-th tile of a level in Morton order: their bits alternate in m, beginning with x.
std::pair<int, int> at_morton(int m) {
    int x = 0, y = 0;
    for (int bit = 0; m >> (2 * bit); ++bit) {
        x |= (m >> (2 * bit) & 1) << bit;
        y |= (m >> (2 * bit + 1) & 1) << bit;
    }
    return {x, y};
}

class SubtreeWriter {
  public:
    std::vector<std::uint8_t> write(const Tree& tree, int level, int x, int y) {
        Bits tiles, contents, below;
        std::vector<double> boxes, errors;
        for (int depth = 0; depth <= kSubtreeLevels; ++depth)
            for (int m = 0; m < 1 << (2 * depth); ++m) {
                const auto [dx, dy] = at_morton(m);
                const auto found = tree.find({level + depth, (x << depth) + dx, (y << depth) + dy});
                const bool is_there = found != tree.end();
                if (depth == kSubtreeLevels) {
                    below.add(is_there);
                    continue;
                }
                tiles.add(is_there);
                contents.add(is_there && found->second.has_content);
                if (!is_there) continue;
                const auto box = box_of(found->second);
                boxes.insert(boxes.end(), box.begin(), box.end());
                errors.push_back(found->second.error_m);
            }
        json_["tileAvailability"] = availability(tiles);
        json_["contentAvailability"] = Json::array({availability(contents)});
        json_["childSubtreeAvailability"] = availability(below);
        json_["tileMetadata"] = 0;
        json_["propertyTables"] =
            Json::array({{{"class", "tile"},
                          {"count", errors.size()},
                          {"properties",
                           {{"box", {{"values", view(boxes.data(), boxes.size() * sizeof(double))}}},
                            {"error", {{"values", view(errors.data(), errors.size() * sizeof(double))}}}}}}});
        json_["buffers"] = Json::array({{{"byteLength", buffer_.size()}}});
        return file();
    }

  private:
    Json availability(const Bits& bits) {
        if (bits.set == 0) return {{"constant", 0}};
        if (bits.set == bits.size) return {{"constant", 1}};
        return {{"bitstream", view(bits.bytes.data(), bits.bytes.size())}, {"availableCount", bits.set}};
    }
    std::size_t view(const void* data, std::size_t bytes) {
        buffer_.resize((buffer_.size() + 7) / 8 * 8);
        json_["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes}});
        const auto* const first = static_cast<const std::uint8_t*>(data);
        buffer_.insert(buffer_.end(), first, first + bytes);
        return json_["bufferViews"].size() - 1;
    }
    std::vector<std::uint8_t> file() const {
        static_assert(std::endian::native == std::endian::little);
        std::string text = json_.dump();
        text.resize((text.size() + 7) / 8 * 8, ' ');
        std::vector<std::uint8_t> bytes;
        const auto put = [&](auto value) {
            std::uint8_t raw[sizeof value];
            std::memcpy(raw, &value, sizeof value);
            bytes.insert(bytes.end(), raw, raw + sizeof value);
        };
        const std::size_t padded = (buffer_.size() + 7) / 8 * 8;
        put(std::uint32_t{0x74627573});  // "subt"
        put(std::uint32_t{1});
        put(static_cast<std::uint64_t>(text.size()));
        put(static_cast<std::uint64_t>(padded));
        bytes.insert(bytes.end(), text.begin(), text.end());
        bytes.insert(bytes.end(), buffer_.begin(), buffer_.end());
        bytes.resize(bytes.size() + padded - buffer_.size());
        return bytes;
    }
    Json json_ = {{"buffers", Json::array()}, {"bufferViews", Json::array()}};
    std::vector<std::uint8_t> buffer_;
};

Json metadata_schema() {
    const Json box = {{"type", "SCALAR"}, {"componentType", "FLOAT64"}, {"array", true},
                      {"count", 12},      {"required", true},           {"semantic", "TILE_BOUNDING_BOX"}};
    const Json error = {{"type", "SCALAR"},
                        {"componentType", "FLOAT64"},
                        {"required", true},
                        {"semantic", "TILE_GEOMETRIC_ERROR"}};
    Json schema;
    schema["id"] = "hexrelief";
    schema["classes"]["tile"]["properties"] = {{"box", box}, {"error", error}};
    return schema;
}

}  // namespace

std::string explicit_tileset(const std::vector<TilesetTile>& tiles, const std::string& content,
                             const std::string& generator) {
    const Tree tree = tree_of(tiles);
    Json json = document_of(tree, generator);
    json["root"] = node_of(tree, tree.at({0, 0, 0}), content);
    return json.dump() + "\n";
}

ImplicitTileset implicit_tileset(const std::vector<TilesetTile>& tiles, const std::string& content,
                                 const std::string& generator) {
    const Tree tree = tree_of(tiles);
    const TilesetTile& root = tree.at({0, 0, 0});
    const int levels = std::get<0>(tree.rbegin()->first) + 1;
    ImplicitTileset out;
    Json json = document_of(tree, generator);
    json["schema"] = metadata_schema();
    json["root"] = {{"boundingVolume", {{"box", box_of(root)}}},
                    {"geometricError", root.error_m},
                    {"refine", "REPLACE"},
                    {"content", {{"uri", content}}},
                    {"implicitTiling",
                     {{"subdivisionScheme", "QUADTREE"},
                      {"subtreeLevels", kSubtreeLevels},
                      {"availableLevels", levels},
                      {"subtrees", {{"uri", "subtrees/{level}/{x}/{y}.subtree"}}}}}};
    out.json = json.dump() + "\n";
    for (const auto& [key, tile] : tree) {
        if (tile.level % kSubtreeLevels != 0) continue;
        const std::string name = "subtrees/" + std::to_string(tile.level) + "/" + std::to_string(tile.x) +
                                 "/" + std::to_string(tile.y) + ".subtree";
        out.subtrees.push_back({name, SubtreeWriter().write(tree, tile.level, tile.x, tile.y)});
    }
    return out;
}

}  // namespace hexrelief::tileset
