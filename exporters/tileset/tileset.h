// 3D Tiles 1.1 (OGC 22-025r4): what viewers are told of a quadtree of GLB files.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace hexrelief::tileset {

// A node of the quadtree, whose root is (0, 0, 0); those of a level below it have twice its x and y, or one
// more. Missing nodes are those without anything below.
struct TilesetTile {
    int level = 0, x = 0, y = 0;                    // y from the top
    std::array<double, 3> low_m = {}, high_m = {};  // of its box in space, in glTF's axes
    double error_m = 0;                             // of what is shown where its children are not
    bool has_content = false;                       // whether there is a GLB
};

// tileset.json with every tile in it. A tile's box holds those of its children, and its error is at least
// theirs. `tiles` are in any order, with the root and the parent of each. content: where their GLBs are, from
// the tileset's folder: "tiles/{level}/{x}/{y}.glb".
std::string explicit_tileset(const std::vector<TilesetTile>& tiles, const std::string& content,
                             const std::string& generator);

// The same by implicit tiling (QUADTREE), with the tiles' true boxes and errors as metadata, since halves of
// the lattice are no halves of space.
struct ImplicitTileset {
    struct Subtree {
        std::string name;  // "subtrees/0/0/0.subtree"
        std::vector<std::uint8_t> bytes;
    };
    std::string json;
    std::vector<Subtree> subtrees;
};
ImplicitTileset implicit_tileset(const std::vector<TilesetTile>& tiles, const std::string& content,
                                 const std::string& generator);

}  // namespace hexrelief::tileset
