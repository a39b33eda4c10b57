// Compiles tinygltf's own code (tinygltf.h says why it is compiled here).
#define TINYGLTF_IMPLEMENTATION
#include "exporters/formats/gltf/tinygltf.h"
