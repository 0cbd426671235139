#pragma once

#include "support/scene_description.hpp"

/// \file
/// Curved shapes as meshes, with the normals of the curved surface.

namespace gmis::tools::pbrt {

/// Part of a disk, sphere or cylinder around the z axis, as pbrt-v4 describes them; angles in
/// degrees.
struct DiskShape {
  double height = 0, radius = 1, inner_radius = 0, phi_max = 360;
};
struct CylinderShape {
  double radius = 1, z_min = -1, z_max = 1, phi_max = 360;
};
struct PartialSphere {
  double radius = 1, z_min = -1, z_max = 1, phi_max = 360;
};

/// Polygons of 128 sides to the turn, with the area of the circle; (u, v) and the side of the
/// normal are pbrt's.
[[nodiscard]] MeshDescription mesh_of(const DiskShape& disk);
/// The same; every side is as wide as the arc that it stands for.
[[nodiscard]] MeshDescription mesh_of(const CylinderShape& cylinder);
[[nodiscard]] MeshDescription mesh_of(const PartialSphere& sphere);

/// Loop's subdivision of a triangle mesh, `levels` times; vertices are then moved to where endless
/// subdivision would move them, and have smooth normals. Edges with one triangle are borders.
/// Nothing when an edge has more than two triangles or two that are not turned the same way, when
/// two borders meet in a vertex, or when a triangle names a vertex twice.
[[nodiscard]] std::optional<MeshDescription> loop_subdivided(const MeshDescription& mesh, int levels);

}  // namespace gmis::tools::pbrt
