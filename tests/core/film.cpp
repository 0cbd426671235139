#include "gmis/result/film.hpp"

#include <cmath>
#include <glm/vec3.hpp>
#include <random>
#include <vector>

#include "gmis/core/compensated_sum.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

TEST_CASE("a film holds the mean of its iterations and the variance of that mean") {
  // Against the two-pass formulas in long double.
  std::mt19937 source(gmis_test::seed(2));
  std::normal_distribution<float> noise(3.0F, 2.0F);
  const int iterations = 50;
  gmis::Film<glm::vec3> film({2, 1});
  std::vector<std::vector<glm::vec3>> frames;
  for (int i = 0; i < iterations; ++i) {
    std::vector<glm::vec3> frame;
    for (int p = 0; p < 2; ++p) frame.emplace_back(noise(source), noise(source), 1e4F + noise(source));
    frames.push_back(frame);
    film.add_iteration(frame);
  }
  for (std::size_t p = 0; p < 2; ++p)
    for (int c = 0; c < 3; ++c) {
      long double mean = 0, squares = 0;
      for (const auto& frame : frames) mean += static_cast<long double>(frame[p][c]) / iterations;
      for (const auto& frame : frames)
        squares += (static_cast<long double>(frame[p][c]) - mean) * (static_cast<long double>(frame[p][c]) - mean);
      CHECK(film.mean(p, c) == Approx(static_cast<double>(mean)).epsilon(1e-13));
      CHECK(film.variance_of_mean(p, c) ==
            Approx(static_cast<double>(squares / (iterations * (iterations - 1)))).epsilon(1e-9));
    }
}

TEST_CASE("joined films have the mean and the variance of all their iterations") {
  // Against the two-pass formulas in long double; a film of a single iteration and one without any
  // are among them.
  std::mt19937 source(gmis_test::seed(7));
  std::normal_distribution<float> noise(3.0F, 2.0F);
  std::vector<float> all;
  gmis::Film<float> joined({1, 1});
  for (const int iterations : {4, 0, 1, 20, 7}) {
    gmis::Film<float> film({1, 1});
    for (int i = 0; i < iterations; ++i) {
      all.push_back(1e3F + noise(source));
      film.add_iteration(std::vector<float>{all.back()});
    }
    joined.join(film);
    long double mean = 0, squares = 0;
    const auto count = static_cast<long double>(all.size());
    for (const float value : all) mean += static_cast<long double>(value) / count;
    for (const float value : all)
      squares += (static_cast<long double>(value) - mean) * (static_cast<long double>(value) - mean);
    CHECK(joined.iterations() == all.size());
    CHECK(joined.mean(0, 0) == Approx(static_cast<double>(mean)).epsilon(1e-13));
    CHECK(joined.variance_of_mean(0, 0) == Approx(static_cast<double>(squares / (count * (count - 1)))).epsilon(1e-9));
  }
}

TEST_CASE("one iteration has no variance, and the estimate of an image follows its definition") {
  gmis::Film<float> film({2, 2});
  film.add_iteration(std::vector<float>{1.0F, 2.0F, 3.0F, 4.0F});
  CHECK(gmis::estimate_of(film).variance == 0.0);
  film.add_iteration(std::vector<float>{3.0F, 2.0F, 3.0F, 4.0F});
  // Pixel 0: mean 2, sample variance 2, variance of the mean 1; the others have none.
  const gmis::ImageEstimate estimate = gmis::estimate_of(film);
  CHECK(estimate.mean == Approx((2.0 + 2.0 + 3.0 + 4.0) / 4.0));
  CHECK(estimate.variance == Approx(0.25));
}

TEST_CASE("a constant stream is reproduced without drift") {
  gmis::Film<float> film({1, 1});
  const std::vector<float> frame{0.1F};
  for (int i = 0; i < 2000000; ++i) film.add_iteration(frame);
  CHECK(film.mean(0, 0) == Approx(static_cast<double>(0.1F)).epsilon(1e-12));
  CHECK(film.variance_of_mean(0, 0) < 1e-30);
}

TEST_CASE("a compensated sum loses nothing that a plain one would") {
  gmis::CompensatedSum<float> sum;
  float plain = 0.0F;
  for (int i = 0; i < 10000000; ++i) {
    sum += 0.1F;
    plain += 0.1F;
  }
  CHECK(sum.value() == Approx(1e7 * static_cast<double>(0.1F)).epsilon(1e-6));
  CHECK(std::abs(plain / 1e6F - 1.0F) > 0.01F);  // the plain one is off by more than a per cent
  gmis::CompensatedSum<double> cancelling;
  for (const double term : {1.0, 1e100, 1.0, -1e100}) cancelling.add(term);
  CHECK(cancelling.value() == 2.0);
  gmis::CompensatedSum<double> infinite;
  infinite.add(std::numeric_limits<double>::infinity());
  infinite.add(1.0);
  CHECK(infinite.value() == std::numeric_limits<double>::infinity());
}
