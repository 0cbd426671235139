#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gmis/transport/state/technique.hpp"

/// \file
/// Names the paths that had contributions left out, so that each can be traced again alone
/// (replay.hpp). The code here runs only when something is rejected.

namespace gmis {

/// Why a contribution is left out of the film.
enum class RejectionCause : std::uint8_t {
  non_finite,  ///< a channel of the weighted contribution is infinite or NaN
  negative,    ///< a channel of the weighted contribution is below 0
  zero_pdf,    ///< the density of a vertex or of a light sample is not above 0, or not finite
};

/// The end that a subpath starts at.
enum class PathKind : std::uint8_t { camera, light };

/// Identifies one path of a run. With the same seed and settings the path can be traced again, bit
/// by bit.
struct PathName {
  PathKind kind = PathKind::camera;  ///< which kind of path it names
  std::uint32_t iteration = 0;       ///< from 1
  std::uint32_t number =
      0;  ///< index of the pixel in the frame (rows from the upper left), or number of the light tree
  friend constexpr bool operator==(const PathName&, const PathName&) = default;
};

/// A path with at least one rejection.
struct RejectedPath {
  PathName path;                                      ///< where something was rejected
  std::uint32_t count = 0;                            ///< rejections on this path
  RejectionCause cause = RejectionCause::non_finite;  ///< of the first rejection
  std::optional<TechniqueId> technique;               ///< of the first rejection; empty when the subpath itself ended
};

/// The first `capacity` paths with rejections, in the order in which they are numbered.
class RejectionLog {
 public:
  static constexpr std::size_t capacity = 16;

  /// Forgets all paths.
  void clear() noexcept { paths_.clear(); }
  /// The rejected paths, in the order in which they were added.
  [[nodiscard]] std::span<const RejectedPath> paths() const noexcept { return paths_; }

  /// Adds one rejection. All rejections of one path must be added consecutively.
  void add(const PathName& path, RejectionCause cause, const std::optional<TechniqueId>& technique) {
    if (!paths_.empty() && paths_.back().path == path)
      ++paths_.back().count;
    else if (paths_.size() < capacity)
      paths_.push_back({path, 1, cause, technique});
  }

  /// Appends the paths of `later`, whose numbers follow those already here, up to `capacity`.
  void append(const RejectionLog& later) {
    const std::size_t room = std::min(later.paths_.size(), capacity - paths_.size());
    paths_.insert(paths_.end(), later.paths_.begin(), later.paths_.begin() + static_cast<std::ptrdiff_t>(room));
  }
  /// Appends the paths of `later` and sets their iteration to `iteration`.
  void append(const RejectionLog& later, std::uint32_t iteration) {
    const std::size_t first = paths_.size();
    append(later);
    for (std::size_t i = first; i < paths_.size(); ++i) paths_[i].path.iteration = iteration;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(paths_);
  }

 private:
  std::vector<RejectedPath> paths_;
};

}  // namespace gmis
