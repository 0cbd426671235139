#include "gmis/core/concepts.hpp"

struct Lambert {
  using Spectrum = glm::vec3;
  gmis::BsdfValue<Spectrum> evaluate(const glm::vec3&, const glm::vec3&, gmis::TransportMode) const { return {}; }
  std::optional<gmis::ScatterSample<Spectrum>> sample(const glm::vec3&, float, const glm::vec2&,
                                                      gmis::TransportMode) const {
    return std::nullopt;
  }
#ifdef GMIS_EXPECT_OK
  bool is_purely_delta() const {
    return false;
  }
#endif
  Spectrum albedo() const {
    return Spectrum(0.5F);
  }
};

static_assert(gmis::Bsdf<Lambert>);
