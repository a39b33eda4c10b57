// Writes 3D Tiles 1.1 (OGC 22-025r4): the description of a quadtree of GLB files for viewers.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace hexrelief::tileset {

// A node of the quadtree. The root is (0, 0, 0); the children of a node have twice its x and y, or one more.
// A node is missing if it has neither content nor descendants.
struct TilesetTile {
    int level = 0, x = 0, y = 0;                    // y counts from the top
    std::array<double, 3> low_m = {}, high_m = {};  // bounding box in space, in glTF's axes
    // Error of the node's own content, shown while its children are not.
    double error_m = 0;
    bool has_content = false;  // there is a GLB
};

// Returns a tileset.json that lists every tile. A tile's box contains those of its children, and its error is
// at least theirs. `tiles` are in any order, with the root and the parent of each. `content` is the pattern
// of the GLBs' paths, relative to the tileset's folder: "tiles/{level}/{x}/{y}.glb".
std::string explicit_tileset(const std::vector<TilesetTile>& tiles, const std::string& content,
                             const std::string& generator);

// A tileset with implicit tiling (QUADTREE). The tiles' true boxes and errors are metadata, since halves of
// the lattice are not halves of space.
struct ImplicitTileset {
    struct Subtree {
        std::string name;  // "subtrees/0/0/0.subtree"
        std::vector<std::uint8_t> bytes;
    };
    std::string json;
    std::vector<Subtree> subtrees;
};
// Returns the tileset with implicit tiling; arguments as for explicit_tileset().
ImplicitTileset implicit_tileset(const std::vector<TilesetTile>& tiles, const std::string& content,
                                 const std::string& generator);

}  // namespace hexrelief::tileset
