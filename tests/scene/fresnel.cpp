#include "gmis/scene/fresnel.hpp"

#include <complex>

#include "support/catch.hpp"

using namespace gmis::scene;

namespace {

/// Fresnel's equations for a complex index, straight from the amplitudes.
double reflectance(double cos_incident, std::complex<double> index) {
  const double sin2 = 1 - cos_incident * cos_incident;
  const std::complex<double> cos_t = std::sqrt(1.0 - sin2 / (index * index));
  const auto s = (cos_incident - index * cos_t) / (cos_incident + index * cos_t);
  const auto p = (index * cos_incident - cos_t) / (index * cos_incident + cos_t);
  return (std::norm(s) + std::norm(p)) / 2;
}

TEST_CASE("dielectrics follow Fresnel's and Snell's laws", "[fresnel]") {
  for (const double eta : {1.1, 1.5, 2.4, 1 / 1.1, 1 / 1.5}) {
    for (const double cosine : {1.0, 0.9, 0.6, 0.3, 0.05}) {
      CAPTURE(eta, cosine);
      const auto exact = fresnel_dielectric(cosine, eta);
      const double sine_beyond = std::sqrt(1 - cosine * cosine) / eta;
      if (sine_beyond > 1) {
        CHECK(exact.reflectance == 1.0);
        continue;
      }
      CHECK(exact.reflectance == Approx(reflectance(cosine, eta)).epsilon(1e-12));
      CHECK(exact.cos_transmitted == Approx(std::sqrt(1 - sine_beyond * sine_beyond)));
      // From the other side the same.
      CHECK(fresnel_dielectric(exact.cos_transmitted, 1 / eta).reflectance == Approx(exact.reflectance).epsilon(1e-9));
      CHECK(fresnel_dielectric(static_cast<float>(cosine), static_cast<float>(eta)).reflectance ==
            Approx(exact.reflectance).margin(1e-5));
    }
    CHECK(fresnel_dielectric(1.0, eta).reflectance == Approx((eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1))));
    CHECK(fresnel_dielectric(0.0, eta).reflectance == Approx(1.0));
  }
  // Brewster's angle: p-polarised light is not reflected, so half of the s-polarised is what is.
  const double brewster = std::cos(std::atan(1.5));
  const double s = (1 - 1.5 * 1.5) / (1 + 1.5 * 1.5);
  CHECK(fresnel_dielectric(brewster, 1.5).reflectance == Approx(s * s / 2));
  CHECK(fresnel_dielectric(0.3, 1.0).reflectance == 0.0);
  CHECK(fresnel_dielectric(1e-30, 1.0).reflectance == 0.0);
}

TEST_CASE("metals follow Fresnel's equations with a complex index", "[fresnel]") {
  for (const double eta : {0.05, 0.2, 1.0, 1.66, 3.0})
    for (const double k : {0.0, 0.5, 2.4, 9.2}) {
      if (k == 0 && eta < 1) continue;  // a dielectric with total reflection, not a metal
      for (const double cosine : {1.0, 0.9, 0.5, 0.1, 0.01}) {
        CAPTURE(eta, k, cosine);
        CHECK(fresnel_conductor(cosine, eta, k) == Approx(reflectance(cosine, {eta, k})).epsilon(1e-9).margin(1e-14));
        CHECK(fresnel_conductor(float(cosine), float(eta), float(k)) ==
              Approx(reflectance(cosine, {eta, k})).margin(2e-5));
      }
      if (eta != 1 || k != 0) CHECK(fresnel_conductor(0.0, eta, k) == Approx(1.0));
    }
}

TEST_CASE("the diffuse reflectance of glass", "[fresnel]") {
  // Closed form of Walsh (1926), in the form of Duntley, for n = 1.5.
  const double n = 1.5, n2 = n * n, n4 = n2 * n2;
  const double closed = 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
                        n2 * (n2 - 1) * (n2 - 1) / std::pow(n2 + 1, 3) * std::log((n - 1) / (n + 1)) -
                        2 * n * n2 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) +
                        8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) * std::log(n);
  CHECK(fresnel_diffuse_reflectance(1.5) == Approx(closed).epsilon(1e-4));
  CHECK(fresnel_diffuse_reflectance(1.0) == 0.0);
}

}  // namespace
