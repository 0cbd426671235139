#pragma once

/// \file
/// The built-in scene layer: a bounding volume hierarchy over triangles and spheres, materials,
/// lights and cameras, made by `gmis::scene::SceneBuilder`. The transport layer does not know it:
/// any scene that meets `gmis::Scene` can stand in its place.

#include "gmis/scene/bvh_scene.hpp"
#include "gmis/scene/either_bsdf.hpp"
#include "gmis/scene/scene_builder.hpp"
