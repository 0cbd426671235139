#define TINYGLTF_IMPLEMENTATION
#include "support/gltf/model.hpp"
