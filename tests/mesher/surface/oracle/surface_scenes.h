// Makes up disparity maps and lattices for the surface oracle, each from a number.
#pragma once

#include <string>

#include "surface_oracle.h"

namespace hexrelief::surface::oracle {

struct Scene {
    DisparityMap map;
    HexMesh2D lattice;
    float background_px = 0;
    Config config;
    std::string name;  // its number, and its contents
};

Scene make_scene(int number);

}  // namespace hexrelief::surface::oracle
