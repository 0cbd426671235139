#pragma once

#include <cstring>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "support/diagnostics.hpp"
#include "support/gltf/model.hpp"

namespace gmis::tools::gltf {

/// The numbers of an accessor with this many components, in a row; normalised integers from −1 or 0 to 1. Throws
/// `InputError` when the file does not hold them all.
[[nodiscard]] inline std::vector<double> numbers_of(const tinygltf::Model& model, int number, int components,
                                                    const SourcePosition& where) {
  const auto fail = [&](const std::string& what) {
    return InputError(where, "accessor " + std::to_string(number) + " " + what);
  };
  if (number < 0 || static_cast<std::size_t>(number) >= model.accessors.size()) throw fail("is not there");
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(number)];
  if (accessor.sparse.isSparse) throw fail("is sparse, which is not supported");
  const int bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
  if (tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)) != components || bytes <= 0)
    throw fail("has the wrong type");
  if (accessor.bufferView < 0 || static_cast<std::size_t>(accessor.bufferView) >= model.bufferViews.size())
    throw fail("has no data");
  const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size()) throw fail("has no buffer");
  const std::vector<unsigned char>& data = model.buffers[static_cast<std::size_t>(view.buffer)].data;
  const auto element = static_cast<std::size_t>(bytes * components);
  const std::size_t stride = view.byteStride > 0 ? view.byteStride : element;
  const std::size_t first = view.byteOffset + accessor.byteOffset;
  const std::size_t size = view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset
                               ? 0
                               : view.byteOffset + view.byteLength;
  if (first > size || accessor.count > size || stride > size ||
      (accessor.count > 0 && (accessor.count - 1) * stride + element > size - first))
    throw fail("goes beyond the end of its buffer");
  std::vector<double> result;
  result.reserve(accessor.count * static_cast<std::size_t>(components));
  const auto read = [&](const unsigned char* place, auto value, double largest) {
    std::memcpy(&value, place, sizeof value);
    const auto number_there = static_cast<double>(value);
    result.push_back(accessor.normalized ? std::max(number_there / largest, -1.0) : number_there);
  };
  for (std::size_t i = 0; i < accessor.count; ++i)
    for (std::size_t c = 0; c < static_cast<std::size_t>(components); ++c) {
      const unsigned char* place = data.data() + first + i * stride + c * static_cast<std::size_t>(bytes);
      switch (accessor.componentType) {
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
          read(place, float{}, 1);
          break;
        case TINYGLTF_COMPONENT_TYPE_BYTE:
          read(place, std::int8_t{}, 127);
          break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
          read(place, std::uint8_t{}, 255);
          break;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
          read(place, std::int16_t{}, 32767);
          break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
          read(place, std::uint16_t{}, 65535);
          break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
          read(place, std::uint32_t{}, 4294967295.0);
          break;
        default:
          throw fail("has a component type that is not supported");
      }
    }
  return result;
}

[[nodiscard]] inline std::vector<glm::dvec3> triples_of(const tinygltf::Model& model, int number,
                                                        const SourcePosition& where) {
  const std::vector<double> numbers = numbers_of(model, number, 3, where);
  std::vector<glm::dvec3> result;
  for (std::size_t i = 0; i < numbers.size(); i += 3) result.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return result;
}

}  // namespace gmis::tools::gltf
