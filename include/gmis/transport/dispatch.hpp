#pragma once

#include "gmis/transport/integrators.hpp"
#include "gmis/transport/plan.hpp"

namespace gmis {

/// Calls `visit.template operator()<Integrator>()` with the integrator that has just the techniques of the plan, and
/// returns what that returns. Emitter hits and next events are in all of them: where the plan has them off they have
/// nothing to work on. The integrator classifies paths where the plan leaves classes out; `RenderSettings::path_classes`
/// are then to be those that were wanted of it.
///
///     dispatch(plan, [&]<class I>() { render(Engine<MyScene, I>(scene, settings)); });
template <class Visit>
decltype(auto) dispatch(const Plan& plan, Visit&& visit) {
  const auto with = [&]<class I>() -> decltype(auto) {
    if (plan.leaves_out_classes()) return visit.template operator()<Classified<I>>();
    return visit.template operator()<I>();
  };
  if (plan.has(Technique::connect)) {
    if (plan.has(Technique::merge)) return with.template operator()<integrators::Vcm>();
    return with.template operator()<integrators::Bpt>();
  }
  if (plan.has(Technique::merge)) return with.template operator()<integrators::PtLtPm>();
  if (plan.has(Technique::splat)) return with.template operator()<integrators::PtLt>();
  return with.template operator()<integrators::Pt>();
}

}  // namespace gmis
