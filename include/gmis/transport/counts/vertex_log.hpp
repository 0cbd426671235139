#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/transport/choose/operation_costs.hpp"
#include "gmis/transport/counts/count_table.hpp"

namespace gmis {

/// Costs of the work at a camera vertex. Unlike `OperationCosts` they tell further vertices from further samples at one vertex: most
/// of the time goes into making a vertex. Fitted to the times of runs with and without counts.
inline constexpr OperationCosts vertex_costs{.ray = 1.0,
                                             .shadow_ray = 0.25,
                                             .connection = 0.2,
                                             .merge_query = 0.05,
                                             .merge = 0.4,
                                             .photon_stored = 0.3,
                                             .projection = 0.0};

/// A non-specular vertex of a camera subpath, with one sample of everything.
template <std::floating_point T>
struct VertexRecord {
  Vec3<T> position;     ///< in scene units
  Vec3<T> normal;       ///< of any length; it points to the side that the subpath came from
  std::uint32_t pixel;  ///< its index in the frame
  std::uint32_t cell;   ///< in `VertexCells`; 0 as logged
  std::uint32_t place;  ///< number of the vertex in its subpath, from 0: a subpath begins with 0
  T throughput;         ///< mean over channels, above 0
  /// By `VertexWork`: what was added to the pixel, mean over channels, over the throughput.
  std::array<T, vertex_work_count> values;
  /// By `VertexWork`: the cost, in the unit of `OperationCosts`; of `children` everything after the vertex.
  std::array<T, vertex_work_count> costs;
};

/// The vertices of the camera subpaths of one row of pixels, written while each vertex is sampled once.
template <std::floating_point T>
class VertexLog {
 public:
  /// Begins an iteration.
  void clear() noexcept { records_.clear(); }
  /// Begins a camera subpath.
  void begin_path() noexcept { first_ = records_.size(); }
  /// Begins the work at a vertex. `value` is the sum of the pixel, `work` all work so far.
  void begin_vertex(const Vec3<T>& position, const Vec3<T>& normal, std::size_t pixel, T throughput, T value,
                    const Counters& work) {
    records_.push_back({position,
                        normal,
                        static_cast<std::uint32_t>(pixel),
                        0,
                        static_cast<std::uint32_t>(records_.size() - first_),
                        throughput,
                        {},
                        {}});
    mark(value, work);
    if (records_.back().place == 0) start_ = cost_;
  }
  /// Ends one kind of work at the latest vertex.
  void end(VertexWork kind, T value, const Counters& work) {
    VertexRecord<T>& record = records_.back();
    const auto place = static_cast<std::size_t>(kind);
    record.values[place] = (value - value_) / record.throughput;
    record.costs[place] = static_cast<T>(cost_of(work, vertex_costs) - cost_);
    mark(value, work);
  }
  /// Ends all work at the latest vertex but that of its children. Until `end_path` the place of the children holds the sums so far.
  void end_vertex() {
    constexpr auto children = static_cast<std::size_t>(VertexWork::children);
    records_.back().values[children] = value_;
    records_.back().costs[children] = static_cast<T>(cost_ - start_);
  }
  /// Ends the camera subpath.
  void end_path(T value, const Counters& work) {
    constexpr auto children = static_cast<std::size_t>(VertexWork::children);
    const auto cost = static_cast<T>(cost_of(work, vertex_costs) - start_);
    for (std::size_t i = first_; i < records_.size(); ++i) {
      VertexRecord<T>& record = records_[i];
      record.values[children] = (value - record.values[children]) / record.throughput;
      record.costs[children] = cost - record.costs[children];
    }
  }
  /// All vertices, path by path.
  [[nodiscard]] const std::vector<VertexRecord<T>>& records() const noexcept { return records_; }

 private:
  void mark(T value, const Counters& work) {
    value_ = value;
    cost_ = cost_of(work, vertex_costs);
  }

  std::vector<VertexRecord<T>> records_;
  std::size_t first_ = 0;
  T value_ = T(0);
  double cost_ = 0.0, start_ = 0.0;  // so far in the iteration; at the first vertex of the path
};

}  // namespace gmis
