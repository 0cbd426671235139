#pragma once

// Catch2 2 and 3.
#if __has_include(<catch2/matchers/catch_matchers_templated.hpp>)
#include <catch2/matchers/catch_matchers_templated.hpp>
#else
#include <catch2/catch.hpp>
#endif

#include <cstdint>
#include <string>

#include "gmis/testing/check_estimator.hpp"
#include "gmis/testing/check_weights.hpp"
#include "gmis/testing/seeded.hpp"

/// \file
/// Matchers for Catch2, versions 2 and 3. The only header of the library that needs Catch2;
/// gmis/gmis.hpp does not include it.

namespace gmis {

namespace detail {
#if __has_include(<catch2/matchers/catch_matchers_templated.hpp>)
/// The description of a matcher for both versions.
class CatchMatcher : public Catch::Matchers::MatcherGenericBase {
 public:
  [[nodiscard]] std::string describe() const override { return text_; }

 protected:
  mutable std::string text_;
};
#else
class CatchMatcher {
 public:
  [[nodiscard]] std::string toString() const { return text_; }

 protected:
  mutable std::string text_;
};
#endif
}  // namespace detail

/// Matches a round, `double round()`, whose mean and variance are the exact ones:
/// `check_estimator`.
class EstimatesExactly : public detail::CatchMatcher {
 public:
  /// With moments from anywhere.
  explicit EstimatesExactly(const ExactMoments& exact, std::uint64_t rounds = 100'000, double level = 1e-4)
      : exact_(exact), rounds_(rounds), level_(level) {}
  /// With those of a scheme.
  EstimatesExactly(const TabulatedProblem& problem, Scheme scheme, std::uint64_t rounds = 100'000, double level = 1e-4)
      : EstimatesExactly(exact_moments(scheme, problem), rounds, level) {}

  /// Runs `round` and returns true when `check_estimator` finds its moments exact.
  template <class Round>
  [[nodiscard]] bool match(const Round& round) const {
    const EstimatorCheck check = check_estimator(round, exact_, rounds_, level_);
    text_ = "estimates exactly\n" + check.text();
    return check.passes();
  }

 private:
  ExactMoments exact_;
  std::uint64_t rounds_;
  double level_;
};

/// Matches a `WeightCheck` that finds nothing.
class SumsToOne : public detail::CatchMatcher {
 public:
  /// `tolerance` goes to `WeightCheck::passes`.
  explicit SumsToOne(double tolerance = 1e-9) : tolerance_(tolerance) {}

  /// True when `check` passes with the tolerance.
  [[nodiscard]] bool match(const WeightCheck& check) const {
    text_ = "weights sum to one\n" + check.text();
    return check.passes(tolerance_);
  }

 private:
  double tolerance_;
};

}  // namespace gmis
