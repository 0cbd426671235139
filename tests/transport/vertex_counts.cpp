#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/transport/counts/counted_work.hpp"
#include "gmis/transport/counts/learn_counts.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The parts of learned counts by themselves: cells, the best number of samples, sums over cells, and what a table makes of variance
// and cost, against a loop by hand and sums over all outcomes.

namespace {

using Cells = gmis::VertexCells<double>;
using Table = gmis::CountTable<double>;
using Record = gmis::VertexRecord<double>;
using gmis::VertexWork;
using V = gmis::Vec3<double>;

const std::array<V, 6> axes{V(1, 0, 0), V(-1, 0, 0), V(0, 1, 0), V(0, -1, 0), V(0, 0, 1), V(0, 0, -1)};

/// A table with the same factors everywhere and W = 1 in `pixels` pixels.
Table same_everywhere(const Table::Entry& entry, double least = 0.05, std::size_t pixels = 1) {
  return {Cells(), std::vector<Table::Entry>(Cells::count, entry), std::vector<double>(pixels, 1.0), least};
}

/// λ √(V/C) and λ √(M/C) with which the importance 1 has `expected` samples.
Table::Entry entry_for(const std::array<double, 4>& expected) {
  Table::Entry entry;
  for (std::size_t k = 0; k < 4; ++k) {
    entry.roulette[k] = expected[k] < 1 ? expected[k] : std::numeric_limits<double>::infinity();
    entry.split[k] = expected[k] > 1 ? expected[k] : 0.0;
  }
  return entry;
}

/// What `draw_counts` reads of a context and a vertex.
struct FakeContext {
  gmis::SampleCounts counts;
};
struct FakeVertex {
  using T = double;
  struct {
    struct {
      V position{0, 0, 0}, geometric_normal{0, 0, 1};
    } point;
  } hit;
  V to_prev{0, 0, 1};
  double throughput = 1;
};

}  // namespace

TEST_CASE("Drawn numbers have their mean, none is far from it, and what cannot be repeated is not") {
  constexpr int draws = 200'000;
  const std::array<double, 4> wanted{0.37, 0.62, 0.21, 0.05};
  const Table table = same_everywhere(entry_for(wanted));
  gmis::Philox source(gmis_test::seed(4));
  std::array<int, 4> sums{};
  std::array<std::array<int, 4>, 4> both{};
  for (int i = 0; i < draws; ++i) {
    const auto counts = gmis::draw_counts(FakeContext{}, table, FakeVertex{}, 0, true, source);
    for (std::size_t k = 0; k < 4; ++k) {
      REQUIRE(counts.expected[k] == wanted[k]);
      REQUIRE((counts.drawn[k] == 0 || counts.drawn[k] == 1));
      sums[k] += counts.drawn[k];
      for (std::size_t j = 0; j < 4; ++j) both[k][j] += counts.drawn[k] * counts.drawn[j];
    }
  }
  const double limit = gmis::normal_quantile(1 - gmis::sidak_level(1e-3, 4) / 2);
  for (std::size_t k = 0; k < 4; ++k) {
    CAPTURE(k);
    CHECK(std::abs(sums[k] - draws * wanted[k]) < limit * std::sqrt(draws * wanted[k] * (1 - wanted[k])) + 1);
  }
  CHECK(both[0][2] == 0);  // one number for all, in turns: they are half a turn apart, and 0.37 and 0.21 of one

  const Table often = same_everywhere(entry_for({5, 5, 5, 5}));
  FakeContext paired;
  paired.counts.connections = gmis::paired_connections;
  CHECK(gmis::draw_counts(FakeContext{}, often, FakeVertex{}, 0, true, source).drawn == std::array{5, 5, 1, 5});
  CHECK(gmis::draw_counts(FakeContext{}, often, FakeVertex{}, 0, false, source).drawn == std::array{5, 5, 1, 1});
  CHECK(gmis::draw_counts(paired, often, FakeVertex{}, 0, true, source).drawn == std::array{5, 1, 1, 5});
  // Integers take no random number.
  gmis::Philox same = source;
  CHECK(gmis::draw_counts(paired, often, FakeVertex{}, 0, true, source).expected == std::array<double, 4>{5, 1, 1, 5});
  CHECK(same() == source());
}

TEST_CASE("Cells: boxes with equal numbers of vertices, six sides each, and far objects apart") {
  gmis::Philox source(gmis_test::seed(1));
  std::vector<V> points;
  for (int i = 0; i < 8000; ++i) {
    const double u = gmis::uniform<double>(source), v = gmis::uniform<double>(source);
    points.push_back({u * u, std::exp(5 * v), gmis::uniform<double>(source)});
  }
  std::vector<V> with_far = points;
  for (int i = 0; i < 80; ++i) with_far[static_cast<std::size_t>(i)] = {1e9, 1e9, 1e9};
  const Cells cells(points), far(with_far);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CAPTURE(axis);
    // A point's box is known from its rank among all points: an oracle without limits.
    const auto place = static_cast<V::length_type>(axis);
    std::vector<double> sorted;
    for (const V& p : points) sorted.push_back(p[place]);
    std::sort(sorted.begin(), sorted.end());
    const std::size_t unit = axis == 0 ? 64 * 6 : axis == 1 ? 8 * 6 : 6;
    for (const V& p : points) {
      const auto rank =
          static_cast<std::size_t>(std::upper_bound(sorted.begin(), sorted.end(), p[place]) - sorted.begin()) - 1;
      REQUIRE(cells(p, axes[0]) / unit % 8 == rank / 1000);
    }
    // One point in a hundred far away moves the limits by a hundredth of the points at most.
    std::size_t moved = 0;
    for (const V& p : points) moved += cells(p, axes[0]) / unit % 8 != far(p, axes[0]) / unit % 8 ? 1U : 0U;
    CHECK(moved < 8 * 90);
  }
  std::set<std::size_t> seen;
  for (const V& axis : axes)
    for (int i = 0; i < 50; ++i) {
      const V tilt(gmis::uniform<double>(source), gmis::uniform<double>(source), gmis::uniform<double>(source));
      const std::size_t cell = cells(points[0], axis + 0.45 * tilt - V(0.225));
      seen.insert(cell);
      REQUIRE(cell == cells(points[0], 7.0 * axis));
    }
  CHECK(seen.size() == 6);
  CHECK(*seen.rbegin() < Cells::count);
  CHECK(Cells()({1e30, -1e30, 0}, axes[5]) == 5);
}

TEST_CASE("The number of samples: the integer of least V/n + C n above 1, the roulette of least M/n + C n below") {
  gmis::Philox source(gmis_test::seed(2));
  for (int i = 0; i < 20'000; ++i) {
    // With λ = 1 the best n minimises T² W² V/n + C n.
    const double v = std::exp(8 * gmis::uniform<double>(source) - 4),
                 cost = std::exp(2 * gmis::uniform<double>(source));
    const double m = v + 2 * gmis::uniform<double>(source),
                 importance = std::exp(4 * gmis::uniform<double>(source) - 2);
    Table::Entry entry;
    entry.split[3] = std::sqrt(v / cost);
    entry.roulette[3] = std::sqrt(m / cost);
    const double n = same_everywhere(entry).count(entry, VertexWork::children, importance);
    const double best_real = importance * std::sqrt(m / cost);
    if (best_real < Table::least_saving) {
      REQUIRE(n == Approx(std::max(0.05, best_real)));
      continue;
    }
    double best = 1;
    for (double k = 2; k <= 8; ++k)
      if (v * importance * importance / k + cost * k < v * importance * importance / best + cost * best) best = k;
    CAPTURE(v, cost, importance);
    REQUIRE(n == best);
  }
  const double infinite = std::numeric_limits<double>::infinity();
  const auto once = entry_for({1, 1, 1, 1}), often = entry_for({9, 9, 9, 9}),
             seldom = entry_for({0.01, 0.2, 0.69, 0.71});
  const Table table = same_everywhere(once, 0.125);
  for (const double importance : {1e-30, 1.0, 1e30, infinite, std::nan("")})
    CHECK(table.count(once, VertexWork::merge, importance) == 1);
  CHECK(table.count(often, VertexWork::merge, 1.0) == 8);
  CHECK(table.count(often, VertexWork::merge, infinite) == 8);
  CHECK(table.count(often, VertexWork::merge, std::nan("")) == 1);
  CHECK(table.count(seldom, VertexWork::next_event, 1.0) == 0.125);
  CHECK(table.count(seldom, VertexWork::connect, 1.0) == 0.2);
  CHECK(table.count(seldom, VertexWork::merge, 1.0) == 0.69);
  CHECK(table.count(seldom, VertexWork::children, 1.0) == 1);
}

TEST_CASE("The log: what each kind of work gave and cost, the children with all that comes after") {
  gmis::VertexLog<double> log;
  gmis::Counters work;
  const auto& cost = gmis::vertex_costs;
  work.rays = 17;  // of paths before
  log.clear();
  log.begin_path();
  log.end_path(4.0, work);  // a path that leaves the scene
  log.begin_path();
  // The first vertex: throughput 0.5, the pixel already has 1.
  log.begin_vertex({1, 2, 3}, {0, 1, 0}, 42, 0.5, 1.0, work);
  ++work.shadow_rays;
  log.end(VertexWork::next_event, 1.25, work);
  work.connections += 2, work.shadow_rays += 2;
  log.end(VertexWork::connect, 1.75, work);
  ++work.merge_queries, work.merges += 3;
  log.end(VertexWork::merge, 3.75, work);
  log.end_vertex();
  work.rays += 2;                                               // a mirror between
  log.begin_vertex({4, 5, 6}, {0, 0, 1}, 42, 0.25, 4.0, work);  // the surface shines: 0.25
  log.end(VertexWork::next_event, 4.0, work);
  log.end(VertexWork::connect, 4.5, work);
  log.end_vertex();
  ++work.rays;
  log.end_path(5.0, work);
  const auto& records = log.records();
  REQUIRE(records.size() == 2);
  CHECK(records[0].position == V(1, 2, 3));
  CHECK(records[0].normal == V(0, 1, 0));
  CHECK(records[0].pixel == 42);
  CHECK((records[0].place == 0 && records[1].place == 1));
  CHECK(records[0].values == std::array<double, 4>{0.5, 1.0, 4.0, 2.5});
  CHECK(records[1].values == std::array<double, 4>{0.0, 2.0, 0.0, 2.0});
  const std::array<double, 4> costs{cost.shadow_ray, 2 * cost.connection + 2 * cost.shadow_ray,
                                    cost.merge_query + 3 * cost.merge, 3 * cost.ray};
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(records[0].costs[k] == Approx(costs[k]));
    CHECK(records[1].costs[k] == Approx(k == 3 ? cost.ray : 0.0).margin(1e-12));
  }
  log.clear();
  CHECK(log.records().empty());
}

TEST_CASE("Mean, second moment and cost of each cell, and factors that give the best numbers") {
  gmis::Philox source(gmis_test::seed(3));
  std::vector<Record> records(5000);
  for (Record& record : records) {
    record.cell = gmis::uniform_index(source, 30);
    for (std::size_t k = 0; k < 4; ++k) {
      record.values[k] = std::exp(3 * gmis::uniform<double>(source)) * (1 + record.cell);
      record.costs[k] = 1 + static_cast<double>(k) + gmis::uniform<double>(source);
    }
  }
  const double borrowed = 8;
  const auto all = gmis::statistics_of<double>(records, borrowed);
  REQUIRE(all.size() == Cells::count);
  const auto entries = gmis::entries_of<double>(all, 0.25, true), no_split = gmis::entries_of<double>(all, 0.25, false);
  for (std::size_t cell = 0; cell < 31; ++cell)
    for (std::size_t k = 0; k < 4; ++k) {
      long double n = 0, x = 0, xx = 0, c = 0, all_x = 0, all_xx = 0, all_c = 0;
      for (const Record& record : records) {
        const long double value = record.values[k];
        all_x += value, all_xx += value * value, all_c += record.costs[k];
        if (record.cell == cell) n += 1, x += value, xx += value * value, c += record.costs[k];
      }
      const long double share = borrowed / static_cast<double>(records.size());
      const auto mean = static_cast<double>((x + share * all_x) / (n + borrowed));
      const auto second = static_cast<double>((xx + share * all_xx) / (n + borrowed));
      const auto cost = static_cast<double>((c + share * all_c) / (n + borrowed));
      CAPTURE(cell, k);
      CHECK(all[cell].mean[k] == Approx(mean).epsilon(1e-12));
      CHECK(all[cell].second[k] == Approx(second).epsilon(1e-12));
      CHECK(all[cell].cost[k] == Approx(cost).epsilon(1e-12));
      CHECK(entries[cell].roulette[k] == Approx(0.25 * std::sqrt(second / cost)));
      CHECK(no_split[cell].roulette[k] == entries[cell].roulette[k]);
      CHECK(no_split[cell].split[k] == 0);
      CHECK(entries[cell].split[k] == Approx(k == 3 ? 0.25 * std::sqrt((second - mean * mean) / cost) : 0.0));
    }
  CHECK(gmis::statistics_of<double>({}, borrowed)[3].mean[0] == 0);
}

TEST_CASE("What a table makes of variance and cost: a sum over all outcomes") {
  // Two vertices. At the first one the next event has the count p < 1 and the children are k; at each second vertex the merging query
  // has the count q < 1. Values are fixed, so all variance is that of the counts.
  for (const double children : {1.0, 2.0, 5.0, 0.25}) {
    const double p = 0.5, q = 0.125, scale = 0.75;
    std::vector<Record> records(2);
    for (std::uint32_t place : {0U, 1U}) {
      records[place].cell = place;
      records[place].place = place;
      records[place].pixel = 1;
    }
    records[0].throughput = 0.5, records[1].throughput = 0.25;
    records[0].values = {3, 0, 0, 0}, records[1].values = {0, 0, 7, 0};
    records[0].values[3] = records[1].throughput * 7 / records[0].throughput;
    records[0].costs = {2, 0, 0, 1 + 4}, records[1].costs = {0, 0, 4, 0};
    // Importance: T W at the first vertex, and T W over the visits at the second.
    std::vector<Table::Entry> entries(Cells::count);
    const double first = 0.5 * scale, second = 0.25 * scale / children;
    entries[0] = entry_for({p, 1, 1, children}), entries[1] = entry_for({1, 1, q, 1});
    for (auto* factors : {&entries[0].split, &entries[0].roulette})
      for (double& factor : *factors) factor /= first;
    for (double& factor : entries[1].roulette) factor /= second;
    const Table table(Cells(), entries, {1.0, scale}, 0.05);
    std::vector<gmis::CellStatistics> statistics(Cells::count);
    statistics[0].mean[3] = records[0].values[3];  // so splitting takes away no variance
    const gmis::IterationFigures made{10.0, 20.0};
    const auto after = gmis::predict<double>(table, statistics, records, 4.0, made);

    // Given the number of second vertices, each outcome of the merging queries; the value of the pixel relative to W.
    const auto moments = [&](int made_children) {
      double mean = 0, square = 0;
      for (unsigned outcome = 0; outcome < 1U << made_children; ++outcome) {
        double probability = 1, value = 0;
        for (int i = 0; i < made_children; ++i) {
          const bool is_done = (outcome >> i & 1U) != 0;
          probability *= is_done ? q : 1 - q;
          value += is_done ? scale * 0.25 / children * 7 / q : 0.0;
        }
        mean += probability * value, square += probability * value * value;
      }
      return std::array{mean, square};
    };
    double mean = 0, square = 0;
    if (children < 1) {
      mean = children * moments(1)[0], square = children * moments(1)[1];
    } else {
      mean = moments(static_cast<int>(children))[0], square = moments(static_cast<int>(children))[1];
    }
    const double of_next_event = std::pow(scale * 0.5 * 3, 2) * (1 / p - 1);
    CAPTURE(children);
    CHECK(after.variance == Approx(made.variance + (square - mean * mean + of_next_event) / 4));
    const double look_up = 0.2, further = 0.6;
    const double cost = 2 * p - 2 + (children - 1) + (4 * q * children - 4) + look_up * (1 + children) +
                        std::max(0.0, children - 1) * further;
    CHECK(after.cost == Approx(made.cost + cost / 4));
  }
}
