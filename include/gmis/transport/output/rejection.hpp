#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gmis/transport/techniques/technique.hpp"

/// \file
/// Which paths had contributions left out: by name, so that one of them can be traced again alone (replay.hpp). Nothing
/// here is touched unless something is rejected.

namespace gmis {

/// Why a contribution never reaches the film.
enum class RejectionCause : std::uint8_t {
  non_finite,
  negative,
  zero_pdf,  ///< the density of a vertex or of a light sample is not above 0, or not finite
};

enum class PathKind : std::uint8_t { camera, light };

/// One path of a run; with the seed and the settings it is traced again bit by bit.
struct PathName {
  PathKind kind = PathKind::camera;
  std::uint32_t iteration = 0;  ///< from 1
  std::uint32_t number = 0;  ///< the pixel's place in the frame, by rows from the upper left; or that of a light tree
  friend constexpr bool operator==(const PathName&, const PathName&) = default;
};

/// A path of which something was rejected.
struct RejectedPath {
  PathName path;
  std::uint32_t count = 0;  ///< rejections along it
  // Of the first of them:
  RejectionCause cause = RejectionCause::non_finite;
  std::optional<TechniqueId> technique;  ///< none where a subpath ended because its own density is of no use
};

/// The first paths of which something was rejected, in the order in which they are numbered.
class RejectionLog {
 public:
  static constexpr std::size_t capacity = 16;

  void clear() noexcept { paths_.clear(); }
  [[nodiscard]] std::span<const RejectedPath> paths() const noexcept { return paths_; }

  /// Rejections of one path come one after the other.
  void add(const PathName& path, RejectionCause cause, const std::optional<TechniqueId>& technique) {
    if (!paths_.empty() && paths_.back().path == path)
      ++paths_.back().count;
    else if (paths_.size() < capacity)
      paths_.push_back({path, 1, cause, technique});
  }

  /// Those of paths that come later.
  void append(const RejectionLog& later) {
    const std::size_t room = std::min(later.paths_.size(), capacity - paths_.size());
    paths_.insert(paths_.end(), later.paths_.begin(), later.paths_.begin() + static_cast<std::ptrdiff_t>(room));
  }
  /// Those that all belong to `iteration`, whatever they say themselves.
  void append(const RejectionLog& later, std::uint32_t iteration) {
    const std::size_t first = paths_.size();
    append(later);
    for (std::size_t i = first; i < paths_.size(); ++i) paths_[i].path.iteration = iteration;
  }

 private:
  std::vector<RejectedPath> paths_;
};

}  // namespace gmis
