#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "gmis/scene/bsdf.hpp"
#include "support/catch.hpp"

// Every Fresnel reflectance and every lobe where its numbers come to an end: indices of 1,
// extinctions of 0, black and white, directions along the normal and along the surface. Fresnel's
// equations against complex amplitudes in long double.

using namespace gmis::scene;

namespace {

using Wide = long double;

Wide conductor(Wide cosine, Wide eta, Wide k) {
  using Complex = std::complex<Wide>;
  const Complex index(eta, k);
  const Wide sin2 = 1 - cosine * cosine;
  const Complex w = std::sqrt(index * index - sin2);
  const Wide s = std::norm(cosine - w) / std::norm(cosine + w);
  const Wide p = std::norm(index * index * cosine - w) / std::norm(index * index * cosine + w);
  return (s + p) / 2;
}

Wide dielectric(Wide cosine, Wide eta) {
  const Wide scaled = eta * eta - 1 + cosine * cosine;
  if (scaled <= 0) return 1;
  const Wide beyond = std::sqrt(scaled) / eta;
  const Wide p = (eta * cosine - beyond) / (eta * cosine + beyond),
             s = (cosine - eta * beyond) / (cosine + eta * beyond);
  return (p * p + s * s) / 2;
}

std::vector<double> cosines() {
  std::vector<double> result{0, 1e-30, 1e-12, 1e-7, 1};
  for (int i = 1; i < 400; ++i) result.push_back(i / 400.0);
  for (int i = 1; i < 30; ++i) result.push_back(1 - std::ldexp(1.0, -i));
  return result;
}

constexpr double edges[] = {0, 1e-8, 1e-4, 1e-2, 0.1, 0.5, 0.999, 1 - 1e-7, 1, 1 + 1e-7, 1.001, 1.5, 3, 10, 100, 1e3};

/// Absolute, of a share of light: of T, and of the amplitudes where an index is far from 1.
template <class T>
bool agree(T found, Wide exact) {
  return found >= T(0) && found <= T(1) &&
         std::abs(static_cast<Wide>(found) - exact) <= 40 * static_cast<Wide>(std::numeric_limits<T>::epsilon());
}

template <class T>
void sweep_conductors() {
  for (const double eta_there : edges)
    for (const double k_there : edges) {
      const T eta = static_cast<T>(eta_there), k = static_cast<T>(k_there);
      if (eta == T(0) && k == T(0)) continue;
      for (const double cosine_there : cosines()) {
        const T cosine = static_cast<T>(cosine_there);
        const T found = fresnel_conductor(cosine, eta, k);
        if (k < T(1e-3) && (cosine < T(1e-5) || eta <= T(1))) {  // steps of the exact value itself: total reflection
          if (found >= T(0) && found <= T(1)) continue;
          CAPTURE(eta, k, cosine, found);
          FAIL("a reflectance is not from 0 to 1");
        }
        const Wide exact = conductor(static_cast<Wide>(cosine), static_cast<Wide>(eta), static_cast<Wide>(k));
        if (agree(found, exact)) continue;
        CAPTURE(eta, k, cosine, found, exact);
        FAIL("a reflectance is not exact");
      }
    }
}

template <class T>
void sweep_dielectrics() {
  for (const double eta_there : {1e-2, 0.1, 0.5, 0.999, 1 - 1e-6, 1.0, 1 + 1e-6, 1.001, 1.5, 3.0, 10.0, 99.0}) {
    const T eta = static_cast<T>(eta_there);
    for (const double cosine_there : cosines()) {
      const T cosine = static_cast<T>(cosine_there);
      const auto found = fresnel_dielectric(cosine, eta);
      CAPTURE(eta, cosine, found.reflectance);
      REQUIRE(found.reflectance >= T(0));
      REQUIRE(found.reflectance <= T(1));
      REQUIRE(found.cos_transmitted >= T(0));
      REQUIRE(found.cos_transmitted <= T(1));
      const Wide scaled = Wide(eta) * eta - 1 + Wide(cosine) * cosine;
      if (eta == T(1) || std::abs(scaled) < 1e-4L || cosine < T(1e-5)) continue;
      REQUIRE(agree(found.reflectance, dielectric(static_cast<Wide>(cosine), static_cast<Wide>(eta))));
    }
  }
}

struct Named {
  std::string name;
  Material<float> material;
};

std::vector<Named> materials_at_their_edges() {
  std::vector<Named> list;
  const std::vector<glm::dvec3> colors{{0, 0, 0}, {1, 1, 1}, {0, 1, 1e-12}, {1, 0, 0.5}};
  const std::vector<double> alphas{0, smallest_alpha, 0.1, 1};
  for (const glm::dvec3& c : colors) {
    list.push_back({"diffuse", make_diffuse(c)});
    list.push_back({"mirror", make_mirror(c)});
    for (const glm::dvec3& d : colors) {
      list.push_back({"sheet", make_diffuse_transmission(c, d)});
      for (const double exponent : {0.0, 1.0, 1e6}) list.push_back({"phong", make_phong(c, d, exponent)});
    }
    for (const double alpha : alphas) {
      list.push_back({"metal of a reflectance", make_conductor_of_reflectance(c, alpha)});
      for (const double eta : {1.0, 1 + 1e-6, 1.5, 99.0})
        list.push_back({"coated", make_coated_diffuse(c, eta, alpha)});
      for (const double eta : {0.0, 1.0, 1e3})
        for (const double k : {0.0, 1e-8, 1.0, 1e3}) {
          list.push_back({"metal", make_conductor(glm::dvec3(eta, 1, eta), glm::dvec3(k, 0, k), alpha)});
          for (const double coat : alphas)
            list.push_back({"coated metal",
                            make_coated_conductor(glm::dvec3(eta, 1, eta), glm::dvec3(k, 0, k), alpha, 1.5, coat)});
        }
    }
  }
  for (const double alpha : alphas)
    for (const double eta : {0.02, 1 / 1.5, 1 - 1e-6, 1.0, 1 + 1e-6, 1.5, 99.0})
      for (const glm::dvec3& c : colors)
        list.push_back({"dielectric", make_dielectric(eta, alpha, Masking::height_correlated, c)});
  return list;
}

bool is_light(const glm::vec3& value) {
  for (int c = 0; c < 3; ++c)
    if (!(value[c] >= 0 && value[c] < std::numeric_limits<float>::infinity())) return false;
  return true;
}

}  // namespace

TEST_CASE("Fresnel's reflectances are exact at their edges and never below 0 or above 1", "[fresnel]") {
  sweep_conductors<float>();
  sweep_conductors<double>();
  sweep_dielectrics<float>();
  sweep_dielectrics<double>();
  // No surface at all.
  for (const double cosine : cosines()) CHECK(fresnel_conductor(static_cast<float>(cosine), 1.0F, 0.0F) == 0.0F);
  CHECK(fresnel_conductor(0.5F, 0.0F, 3.0F) == 1.0F);
}

TEST_CASE("no lobe gives a value that is negative or no number, whatever its parameters and directions", "[fresnel]") {
  std::vector<glm::vec3> directions;
  for (const double z : {1.0, 1 - 1e-7, 0.7, 0.01, 1e-4, 1e-7, 1e-20, -1e-20, -1e-7, -0.3, -1.0})
    for (const double turn : {0.0, 1e-4, 1.5707963, 3.1415926})
      directions.push_back(glm::normalize(
          glm::vec3(glm::dvec3(std::cos(turn) * std::sqrt(1 - z * z), std::sin(turn) * std::sqrt(1 - z * z), z))));
  const glm::vec3 normal(0, 0, 1);
  for (const auto& [name, material] : materials_at_their_edges()) {
    const SurfaceBsdf<float> bsdf(material, normal, normal);
    CAPTURE(name, material.alpha, material.eta, material.metal_eta.x, material.metal_k.x);
    REQUIRE(is_light(bsdf.albedo()));
    for (const glm::vec3& prev : directions) {
      for (const auto mode : {gmis::TransportMode::radiance, gmis::TransportMode::importance}) {
        for (const glm::vec3& next : directions) {
          const auto value = bsdf.evaluate(prev, next, mode);
          if (is_light(value.value) && value.pdf.forward.value >= 0 && value.pdf.reverse.value >= 0) continue;
          CAPTURE(prev.x, prev.y, prev.z, next.x, next.y, next.z, value.value.x, value.value.y, value.value.z);
          FAIL("a value or a density is negative or no number");
        }
        for (const float u : {0.0F, 0.25F, 0.5F, 0.999999F})
          for (const glm::vec2 uv : {glm::vec2(0.3F, 0.6F), glm::vec2(0, 0), glm::vec2(0.999999F, 0.5F)})
            if (const auto sample = bsdf.sample(prev, u, uv, mode)) {
              if (is_light(sample->weight) && std::abs(glm::length(sample->to_next) - 1) < 1e-3F) continue;
              CAPTURE(u, prev.z, sample->weight.x, sample->weight.y, sample->weight.z);
              FAIL("a sample has no direction, or a weight that is negative or no number");
            }
      }
    }
  }
}
