#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace gmis {

/// A solution of the normal equations A β = b, A symmetric and positive semidefinite, n × n, row by
/// row: Cholesky's factorisation with pivoting, after scaling the diagonal of A to one. Columns
/// that depend on others, to `tolerance` relative to their size, get the coefficient 0; so a copy
/// of a column does no harm. O(n³).
[[nodiscard]] inline std::vector<double> solve_semidefinite(std::vector<double> a, std::span<const double> b,
                                                            double tolerance = 1e-11) {
  const std::size_t n = b.size();
  std::vector<double> scale(n), x(n);
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) {
    scale[i] = a[i * n + i] > 0.0 ? 1.0 / std::sqrt(a[i * n + i]) : 0.0;
    order[i] = i;
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) a[i * n + j] *= scale[i] * scale[j];
  const auto at = [&](std::size_t i, std::size_t j) -> double& { return a[order[i] * n + order[j]]; };

  // The lower triangle, in pivoted order, becomes the factor L of A = L Lᵀ.
  std::size_t rank = 0;
  for (; rank < n; ++rank) {
    std::size_t pivot = rank;
    for (std::size_t i = rank + 1; i < n; ++i)
      if (at(i, i) > at(pivot, pivot)) pivot = i;
    if (!(at(pivot, pivot) > tolerance)) break;
    std::swap(order[rank], order[pivot]);
    const double root = std::sqrt(at(rank, rank));
    at(rank, rank) = root;
    for (std::size_t i = rank + 1; i < n; ++i) at(i, rank) /= root;
    for (std::size_t i = rank + 1; i < n; ++i)
      for (std::size_t j = rank + 1; j < n; ++j) at(i, j) -= at(i, rank) * at(j, rank);
  }
  std::vector<double> y(rank);
  for (std::size_t i = 0; i < rank; ++i) {
    y[i] = b[order[i]] * scale[order[i]];
    for (std::size_t j = 0; j < i; ++j) y[i] -= at(i, j) * y[j];
    y[i] /= at(i, i);
  }
  for (std::size_t i = rank; i-- > 0;) {
    for (std::size_t j = i + 1; j < rank; ++j) y[i] -= at(j, i) * y[j];
    y[i] /= at(i, i);
  }
  for (std::size_t i = 0; i < rank; ++i) x[order[i]] = y[i] * scale[order[i]];
  return x;
}

}  // namespace gmis
