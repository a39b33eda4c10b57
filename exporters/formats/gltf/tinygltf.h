// tinygltf's types under a name of our own. libdraco exports its own tinygltf, built with another layout of
// the same classes: the order of linking would decide which of the two a call reaches (Debian's shared
// tinygltf crashed that way). tinygltf.cpp compiles it, without stb, because images come encoded already.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define tinygltf hexrelief_tinygltf
#include <tiny_gltf.h>
