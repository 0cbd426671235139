#include "gmis/render/expected_law.hpp"

#include <cmath>

#include "support/catch.hpp"

namespace {

/// Forecasts for these factors on the radius, of the variance V₀ + V₁ / factor²; and others that
/// tell nothing of it.
gmis::Choice choice_of(double independent, double merging) {
  gmis::Choice choice;
  choice.expected_iterations = 300;
  for (const double light_paths : {0.5, 1.0})
    for (const double factor : {2.0, 4.0, 8.0, 12.0}) {
      gmis::Forecast forecast;
      forecast.counts.light_paths = light_paths;
      forecast.counts.local_merges = true;
      forecast.counts.radius_factor = factor;
      forecast.variance = light_paths < 1 ? 77.0 : independent + merging / (factor * factor);
      choice.forecasts.push_back(forecast);
    }
  gmis::Forecast without = choice.forecasts.back();
  without.counts.merges = without.counts.local_merges = false;
  without.counts.radius_factor = 1.0;
  without.variance = 5.0;
  choice.forecasts.push_back(without);
  return choice;
}

}  // namespace

TEST_CASE("The share of merging in a forecast is that of its inverse square") {
  const gmis::Choice choice = choice_of(0.3, 8.0);
  for (const std::size_t chosen : {4U, 5U, 6U, 7U}) {
    const double part = 8.0 / std::pow(choice.forecasts[chosen].counts.radius_factor, 2);
    CHECK(gmis::merging_share(choice.forecasts, chosen) == Approx(part / (0.3 + part)));
  }
  CHECK(gmis::merging_share(choice.forecasts, 0) == 0.0);  // the same for every factor
  CHECK(gmis::merging_share(choice.forecasts, 8) == 0.0);
  // Chance may make it less than nothing, or more than all.
  CHECK(gmis::merging_share(choice_of(0.3, -0.1).forecasts, 5) == 0.0);
  CHECK(gmis::merging_share(choice_of(-0.1, 8.0).forecasts, 5) == 1.0);
  CHECK(gmis::merging_share({choice.forecasts[5], choice.forecasts[8]}, 0) == 0.0);  // nothing to compare with
}

TEST_CASE("The law of a choice has its variance where the disk has its mean area") {
  gmis::Choice choice = choice_of(0.3, 8.0);
  choice.chosen = 5;
  for (const double alpha : {0.75, 0.4}) {
    gmis::RenderSettings settings;
    settings.alpha = alpha;
    const gmis::ErrorLaw law = gmis::expected_law(choice, choice.forecasts[5].counts, settings);
    CHECK(law.alpha == alpha);
    CHECK(law.independent == Approx(0.3));
    long double disk = 0;
    for (int i = 1; i <= 300; ++i) disk += std::pow(static_cast<long double>(i), alpha - 1) / 300;
    CHECK(law.merging == Approx(8.0 / 16 * static_cast<double>(disk)).epsilon(1e-3));
    // Half the radius, four times the variance of merging.
    gmis::SampleCounts narrower = choice.forecasts[5].counts;
    narrower.radius_factor /= 2;
    CHECK(gmis::expected_law(choice, narrower, settings).merging == Approx(4 * law.merging));
    CHECK(gmis::expected_law(choice, narrower, settings).independent == law.independent);
    // An iteration whose disk is the mean one.
    const double iteration = std::pow(static_cast<double>(disk), 1 / (alpha - 1));
    CHECK(law.independent + law.merging * std::pow(iteration, 1 - alpha) ==
          Approx(choice.forecasts[5].variance).epsilon(1e-3));
  }
  choice.chosen = 8;  // merges nothing
  gmis::RenderSettings settings;
  settings.alpha = 0.75;
  const gmis::ErrorLaw plain = gmis::expected_law(choice, choice.forecasts[8].counts, settings);
  CHECK(plain.alpha == 1.0);
  CHECK(plain.independent == 5.0);
  CHECK(plain.merging == 0.0);
}

TEST_CASE("Without a choice only the radius and the sampler are known") {
  gmis::SampleCounts merges, plain;
  plain.merges = false;
  gmis::RenderSettings settings;
  settings.alpha = 0.6;
  CHECK(gmis::expected_law({}, merges, settings).alpha == 0.6);
  CHECK(gmis::expected_law({}, merges, settings).merging_share_at(100) == 0.0);
  CHECK(gmis::expected_law({}, merges, settings).evenness == 0.0);
  CHECK(gmis::expected_law({}, plain, settings).alpha == 1.0);
  settings.sampler = gmis::Sampler::sobol;
  CHECK(gmis::expected_law({}, plain, settings).evenness == gmis::usual_evenness);
}

TEST_CASE("Evenly spread numbers change nothing of a law but what remains of it") {
  gmis::Choice choice = choice_of(0.3, 8.0);
  choice.chosen = 5;
  gmis::RenderSettings settings;
  const gmis::ErrorLaw independent = gmis::expected_law(choice, choice.forecasts[5].counts, settings);
  settings.sampler = gmis::Sampler::sobol;
  const gmis::ErrorLaw even = gmis::expected_law(choice, choice.forecasts[5].counts, settings);
  CHECK(even.independent == independent.independent);
  CHECK(even.merging == independent.merging);
  for (const double n : {1.0, 8.0}) CHECK(even.error_at(n) == independent.error_at(n));
  CHECK(even.error_at(800) == Approx(independent.error_at(800) * std::sqrt(1 - gmis::usual_evenness * 0.9)));
}
