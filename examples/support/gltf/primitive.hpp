#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "support/gltf/document.hpp"

namespace gmis::tools::gltf {

/// The vertices of a part of a mesh, unpacked where KHR_draco_mesh_compression packs them.
class Primitive {
 public:
  /// `name` is what messages call the mesh.
  Primitive(const Document& document, const Json& json, std::string name);

  [[nodiscard]] const Json& json() const { return json_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] bool has(const std::string& attribute) const;
  [[nodiscard]] std::size_t components_of(const std::string& attribute) const;
  /// The numbers of an attribute in a row, `components` for each vertex; empty where there are
  /// none.
  [[nodiscard]] std::vector<double> numbers(const std::string& attribute, std::size_t components) const;
  [[nodiscard]] std::vector<glm::dvec3> triples(const std::string& attribute) const;
  /// Three corners a triangle, of lists, strips and fans. Throws for a vertex that is not there.
  [[nodiscard]] std::vector<std::array<int, 3>> triangles(std::size_t vertices) const;
  /// Points or lines.
  [[nodiscard]] bool has_no_triangles() const { return mode_ < 4; }

 private:
  struct Unpacked {
    std::map<std::string, std::pair<std::size_t, std::vector<double>>> attributes;  ///< with their components
    std::vector<double> indices;
  };
  void unpack(const Json& packed);

  const Document& document_;
  const Json& json_;
  std::string name_;
  int mode_ = 4;
  std::optional<Unpacked> unpacked_;
};

/// Coordinates of a mesh in which each triangle has a patch of an image of its own. Whatever is
/// linear over a triangle, as colours at vertices or another set of coordinates, is then an image
/// of four texels a triangle, and exact: a patch of 2 × 2 texels holds any linear function.
class TriangleCharts {
 public:
  /// `corners` are coordinates, three a triangle, whose directions the new ones keep, so that
  /// normal maps keep their tangents; or none.
  TriangleCharts(std::size_t triangles, const std::vector<glm::dvec2>& corners);

  /// Three a triangle.
  [[nodiscard]] const std::vector<glm::dvec2>& uv() const { return uv_; }
  /// The function with these values at the corners, three a triangle.
  [[nodiscard]] TextureHandle function(const std::vector<glm::dvec3>& values, LoadBudget& budget,
                                       const SourcePosition& where) const;
  /// The same function for values from 0 to 1, with 0 and 1 as its bounds. An image has the bounds
  /// of its texels, which lie outside of the triangles and may be negative.
  [[nodiscard]] TextureHandle fractions(const std::vector<glm::dvec3>& values, LoadBudget& budget,
                                        const SourcePosition& where) const;

 private:
  int side_ = 1;                    ///< patches in a row
  std::vector<glm::dvec2> places_;  ///< of corners in the patch of their triangle: from texel to texel, downwards
  std::vector<glm::dvec2> uv_;
};

}  // namespace gmis::tools::gltf
