#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/transport/counts/count_table.hpp"
#include "gmis/transport/counts/vertex_log.hpp"

namespace gmis {

/// Variance and cost of one iteration, per pixel: the variance relative to the squared value of the pixel, as in relMSE.
struct IterationFigures {
  double variance = 0.0;  ///< mean over the pixels, without the worst 0.1 %
  double cost = 0.0;      ///< unit: `OperationCosts`

  constexpr IterationFigures& operator+=(const IterationFigures& other) noexcept {
    variance += other.variance;
    cost += other.cost;
    return *this;
  }
  [[nodiscard]] friend constexpr IterationFigures operator+(IterationFigures a, const IterationFigures& b) noexcept {
    return a += b;
  }
};

/// Mean, second moment and cost of one sample of each kind of work in one cell.
struct CellStatistics {
  std::array<double, vertex_work_count> mean{};    ///< of what a sample gives, over the throughput
  std::array<double, vertex_work_count> second{};  ///< second moment of it
  std::array<double, vertex_work_count> cost{};    ///< unit: `OperationCosts`
};

namespace detail {

/// Visits of the vertices of a subpath and factors on its work, when every vertex has its expected number of samples.
/// Calls `visit(record, work, visits, expected)` for each kind of work at each vertex: `visits` is the expected number of times
/// that the vertex is made. All records are of one subpath.
template <std::floating_point T, class Visit>
void for_each_count(const CountTable<T>& table, std::span<const VertexRecord<T>> path, Visit&& visit) {
  T visits(1);
  for (const VertexRecord<T>& record : path) {
    const auto& entry = table.at(std::size_t{record.cell});
    const T importance = record.throughput / visits * table.pixel_scale(record.pixel);
    T children(1);
    for (std::size_t k = 0; k < vertex_work_count; ++k) {
      const auto work = static_cast<VertexWork>(k);
      const T expected = table.count(entry, work, importance);
      visit(record, work, visits, expected);
      if (work == VertexWork::children) children = expected;
    }
    visits *= children;
  }
}

/// The subpaths of a list of vertices: calls `visit(path)` for each.
template <std::floating_point T, class Visit>
void for_each_path(std::span<const VertexRecord<T>> records, Visit&& visit) {
  for (std::size_t begin = 0; begin < records.size();) {
    std::size_t end = begin + 1;
    while (end < records.size() && records[end].place != 0) ++end;
    visit(records.subspan(begin, end - begin));
    begin = end;
  }
}

}  // namespace detail

/// The statistics of every cell of `VertexCells`; the records name their cells. Cells with few vertices borrow from all: as if each had `borrowed` more, of the mean of all.
template <std::floating_point T>
[[nodiscard]] std::vector<CellStatistics> statistics_of(std::span<const VertexRecord<T>> records, double borrowed) {
  std::vector<CellStatistics> all(VertexCells<T>::count);
  std::vector<double> counts(all.size(), 0.0);
  CellStatistics whole;
  const auto add = [](CellStatistics& to, const CellStatistics& from, double factor) {
    for (std::size_t k = 0; k < vertex_work_count; ++k) {
      to.mean[k] += factor * from.mean[k];
      to.second[k] += factor * from.second[k];
      to.cost[k] += factor * from.cost[k];
    }
  };
  for (const VertexRecord<T>& record : records) {
    CellStatistics one;
    for (std::size_t k = 0; k < vertex_work_count; ++k) {
      one.mean[k] = static_cast<double>(record.values[k]);
      one.second[k] = square(one.mean[k]);
      one.cost[k] = static_cast<double>(record.costs[k]);
    }
    add(all[record.cell], one, 1.0);
    add(whole, one, 1.0);
    counts[record.cell] += 1.0;
  }
  const double number = static_cast<double>(records.size());
  for (std::size_t cell = 0; cell < all.size(); ++cell) {
    if (number > 0.0) add(all[cell], whole, borrowed / number);
    CellStatistics mean;
    if (counts[cell] + borrowed > 0.0) add(mean, all[cell], 1.0 / (counts[cell] + borrowed));
    all[cell] = mean;
  }
  return all;
}

/// The factors of all cells, for λ = `lambda`. Only subpaths are split, and those only if `splits`: the variance within a cell is to a large part that between
/// its vertices, which more samples at one vertex leave as it is.
template <std::floating_point T>
[[nodiscard]] std::vector<typename CountTable<T>::Entry> entries_of(std::span<const CellStatistics> cells,
                                                                    double lambda, bool splits) {
  constexpr double least_cost = 0.15;  // of work that ends before it is counted
  std::vector<typename CountTable<T>::Entry> entries(cells.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (std::size_t k = 0; k < vertex_work_count; ++k) {
      const CellStatistics& of = cells[cell];
      const double cost = std::max(least_cost, of.cost[k]);
      entries[cell].roulette[k] = static_cast<T>(lambda * std::sqrt(of.second[k] / cost));
      if (splits && static_cast<VertexWork>(k) == VertexWork::children)
        entries[cell].split[k] =
            static_cast<T>(lambda * std::sqrt(std::max(0.0, of.second[k] - square(of.mean[k])) / cost));
    }
  return entries;
}

/// What a table makes of the variance and the cost of an iteration, from subpaths with one sample of everything that had no part in
/// the table (`paths` in all, those without a vertex included): a roulette adds (1/n − 1) x² T² W² for a sample x, and n samples for one take away (1 − 1/n) (x − mean)² T² W². `made`
/// are the figures with one sample of everything. A vertex with counts costs `look_up` rays more, and the rays of a second child
/// `further_child` times those of the first, which are more coherent. The 0.1 % of the subpaths with the most change are left out.
template <std::floating_point T>
[[nodiscard]] IterationFigures predict(const CountTable<T>& table, std::span<const CellStatistics> statistics,
                                       std::span<const VertexRecord<T>> records, double paths,
                                       const IterationFigures& made) {
  constexpr double look_up = 0.2, further_child = 1.6;
  std::vector<double> changes;
  double cost = 0.0;
  detail::for_each_path<T>(records, [&](std::span<const VertexRecord<T>> path) {
    double change = 0.0;
    detail::for_each_count(table, path, [&](const VertexRecord<T>& record, VertexWork work, T visits, T expected) {
      const auto k = static_cast<std::size_t>(work);
      const auto n = static_cast<double>(expected), v = static_cast<double>(visits);
      const auto x = static_cast<double>(record.values[k]);
      // The cost of the next segment alone: what comes after it has visits of its own.
      auto own = static_cast<double>(record.costs[k]);
      if (work == VertexWork::children && &record != &path.back()) {
        const VertexRecord<T>& next = *(&record + 1);
        for (const T part : next.costs) own -= static_cast<double>(part);
      }
      cost += (v * n - 1.0) * own;
      if (work == VertexWork::children) cost += v * (look_up + std::max(0.0, n - 1.0) * (further_child - 1.0) * own);
      if (n == 1.0) return;
      const double scale =
          static_cast<double>(record.throughput) * static_cast<double>(table.pixel_scale(record.pixel));
      const double mean = n > 1.0 ? statistics[record.cell].mean[k] : 0.0;
      change += (1.0 / n - 1.0) / v * square(scale * (x - mean));
    });
    changes.push_back(change);
  });
  if (changes.empty()) return made;
  const auto kept = static_cast<double>(changes.size() - trimmed_pixels(changes.size()));
  return {made.variance + trimmed_mean(changes, 1) * kept / paths, made.cost + cost / paths};
}

}  // namespace gmis
