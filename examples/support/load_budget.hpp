#pragma once

#include <cstdint>
#include <string>

#include "support/diagnostics.hpp"

namespace gmis::tools {

/// The limit on the memory that the reading of one scene takes. All that a file can make large is
/// counted here before the memory is taken: bytes read and unpacked, texels, shapes, numbers of
/// accessors, materials, lights; and how often files are opened.
class LoadBudget {
 public:
  /// In bytes; three quarters of the memory of this machine if it is not given.
  explicit LoadBudget(std::uintmax_t limit = default_limit()) : limit_(limit) {}

  /// Counts this number of bytes, for `what` ("the image \"a.png\""). Throws `InputError`, which
  /// names it, when there is no room.
  void take(std::uintmax_t bytes, const std::string& what, const SourcePosition& where);
  /// Counts the same number for each of `count` things.
  void take(std::uintmax_t count, std::uintmax_t bytes_each, const std::string& what, const SourcePosition& where);
  /// Counts the opening of a file.
  void open_file(const SourcePosition& where);
  [[nodiscard]] std::uintmax_t taken() const { return taken_; }
  [[nodiscard]] std::uintmax_t left() const { return limit_ - taken_; }

  [[nodiscard]] static std::uintmax_t default_limit();

 private:
  std::uintmax_t limit_, taken_ = 0, files_ = 0;
};

/// About what a triangle takes once all is built: in the description, the builder and the scene.
inline constexpr std::uintmax_t bytes_of_triangle = 500;
/// About what a material, a light, a texture or a name takes once all is built.
inline constexpr std::uintmax_t bytes_of_element = 1000;

}  // namespace gmis::tools
