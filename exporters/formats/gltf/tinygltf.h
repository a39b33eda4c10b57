// tinygltf's types under a name of our own. libdraco exports a tinygltf of its own, built with another layout
// of the same classes: which of the two a call reached would depend on the order of linking (Debian's shared
// tinygltf crashed that way). tinygltf.cpp compiles it, without stb, because images come encoded already.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define tinygltf hexrelief_tinygltf
#include <tiny_gltf.h>
