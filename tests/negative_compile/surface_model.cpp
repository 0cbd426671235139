#include "gmis/scene/surface_model.hpp"

struct Nothing {
  using Spectrum = glm::vec3;
  struct Material {};
  Nothing(const Material&, const glm::vec3&, const glm::vec3&) {}
  gmis::BsdfValue<Spectrum> evaluate(const glm::vec3&, const glm::vec3&, gmis::TransportMode) const { return {}; }
  std::optional<gmis::ScatterSample<Spectrum>> sample(const glm::vec3&, float, const glm::vec2&,
                                                      gmis::TransportMode) const {
    return std::nullopt;
  }
  bool is_purely_delta() const { return true; }
  Spectrum albedo() const { return Spectrum(0); }
};

#ifdef GMIS_EXPECT_OK
inline void add_effects_of(const Nothing::Material&, gmis::Effects&) {}
#endif

static_assert(gmis::scene::SurfaceModel<Nothing, float>);
