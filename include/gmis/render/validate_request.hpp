#pragma once

#include <cmath>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"
#include "gmis/render/render_request.hpp"

namespace gmis {

/// Throws std::invalid_argument for a request that no run can fulfil, and says what to change. The
/// engine looks at the settings itself (`validated`).
GMIS_RARE inline void validate(const RenderRequest& request) {
  const Budget& budget = request.budget;
  require_argument(!budget.seconds || !std::isnan(*budget.seconds),
                   "Budget::seconds is not a number: leave it unset for no limit");
  require_argument(!budget.relative_error || *budget.relative_error > 0.0,
                   "Budget::relative_error must be above 0: leave it unset for no limit");
  require_argument(request.rejection_limit.share >= 0.0,
                   "RejectionLimit::share must be 0 or more: infinity allows any number of rejections");
  require_argument(!request.crop || glm::all(glm::lessThanEqual(request.crop->lower, request.crop->upper)),
                   "RenderRequest::crop ends before it begins: it has two corners, not a corner and a size");
  require_argument(request.ranks.count() == 1 || !request.keeps_contributions(),
                   "several ranks make no pictures of techniques, path classes and lights: render those with one");
  require_argument(!request.class_pictures || request.settings.path_classes,
                   "RenderRequest::class_pictures asks for a picture of each of RenderSettings::path_classes, which is "
                   "not set: set it, to PathClassSet::all() for all");
}

}  // namespace gmis
